"""What to say where a request of the GUI was refused, or was not answered.  No Qt, no ROS."""

import os

# By request: what failed, in the words of the window.
REFUSED = {
    "set_team": "the simulation does not take the team as edited, and keeps its own",
    "set_topology": "the controller does not take the graph as edited, and keeps its own",
    "set_parameters": "the controller does not take the parameters as edited, and keeps its own",
    "set_speed": "the speed stays as it was",
    "simulated_time": "the simulation was not started",
    "restored_time": "programs started from now on still take simulated time for theirs",
    "reset": "the robots were not put back to where they began",
    "pause": "the simulation was not paused, nor does it go on",
    "pause_after": "the run has no end of itself",
    "paused": "the simulation was not paused",
    "step": "the simulation made no step",
    "start": "the controller was not started",
    "stop": "the controller was not stopped; EMERGENCY STOP stops all robots",
    "emergency": "the emergency stop was not passed on",
    "hold": "the robot was not pushed",
    "save": "the run was not saved",
    "keep": "the run before was not kept",
    "write": "the run's files were not brought up to date",
    "end_control": "the controller was not ended",
    "watch": "the sensors shown are not read",
}
REFUSED["parameters"] = REFUSED["set_parameters"]
# By server: who answers, in the words of the window.
SERVERS = {
    "pioneer_control": "the controller",
    "stage": "the simulation",
    "master": "the ROS master",
}


def refused(name, answer, directory):
    """Return a text on the refused request ``name``: what failed, and why as ``answer`` has it.

    ``directory``: of files that are the GUI's own, which mean nothing to a person.
    """
    why = without_own_files(str(answer), directory)
    return "{}: {}".format(REFUSED.get(name, "not done ({})".format(name)), why)


def without_own_files(text, directory):
    """Return ``text`` without the names of the files in ``directory`` before what is said of them."""
    own = str(directory) + os.sep
    before, found, rest = text.partition(own)
    while found:
        _, colon, said = rest.partition(": ")
        if not colon:
            break
        before, found, rest = (before + said).partition(own)
    return before + found + rest


def no_answer(name, server):
    """Return a text on the request ``name``, to which ``server`` has not answered yet."""
    return "{}: {} has not answered yet".format(name.replace("_", " "), SERVERS.get(server, server))
