"""The command ``mrs-simulator``: all that needs no ROS, under one name."""

import contextlib
import importlib
import os
import signal
import sys

from mrs_simulator.core.garbage import loading
from mrs_simulator.core.program import below
from mrs_simulator.core.writing import printing
from mrs_simulator.version import __version__

COMMANDS = {
    "experiment": ("study.run.command", "main", "run a scenario: run.csv, figures, verdict"),
    "sweep": ("study.run.command", "sweep_main", "run a scenario under many values of its keys"),
    "report": ("study.results.report", "main", "make figures and verdict of a recorded run again"),
    "figure": ("study.results.figure_command", "main", "draw one figure of chosen parts of a run"),
    "reproduce": ("study.results.reproduce", "main", "run again what made a figure, compare bytes"),
    "view": ("study.draw.view", "main", "play a run, or save it as an animation"),
    "check_protocol": ("study.check.check_protocol", "main", "would a wrong law fail its verdict?"),
    "break": ("study.search.break_command", "main", "search the run that breaks a requirement"),
    "assure": ("study.search.assure_command", "main", "show that runs at random keep requirements"),
    "margins": ("study.search.margins_command", "main", "measure by how much robots may differ"),
    "requirements": ("study.analyses.signal_listing", "main", "list the signals of requirements"),
    "analyse": ("study.analyses.analyse_command", "main", "find out what a law is, by asking it"),
    "lossy_edges": (
        "study.analyses.lossy_edges",
        "main",
        "consensus under many losses, against theory",
    ),
    "noise_gain": ("study.analyses.noise_gain", "main", "consensus under noise, against theory"),
    "compile": ("study.run.compile_ahead", "main", "compile shipped laws before long runs"),
    "gui": ("rqt_plugin.local_side.command", "main", "open the window of studies, without ROS"),
    "docs": ("core.doc_pages", "main", "print a page of the documentation, as errors name it"),
    "scenarios": ("scenario.shipped", "main", "list the scenarios that ship"),
}
BAD_INPUT = 2  # exit code
TICKS = "20"  # [-] of a core's clock until they sleep, as a power of 2: less than a millisecond


@printing
def main(argv=None):
    """Run the command that ``argv`` names; exits with 2 for bad input, else with the command's code."""
    argv = sys.argv[1:] if argv is None else list(argv)
    name = argv[0] if argv else "--help"
    if name in ("-h", "--help"):
        print(_usage())
        sys.exit(0 if argv else BAD_INPUT)
    if name == "--version":
        print("mrs-simulator {}".format(__version__))
        return
    if name not in COMMANDS:
        from mrs_simulator.core.fields import unknown_name

        print(unknown_name("mrs-simulator: command", name, COMMANDS), file=sys.stderr)
        sys.exit(BAD_INPUT)
    # An interrupt while modules load ends the program silently; then the command handles it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    module, function, _ = COMMANDS[name]
    if "numpy" not in sys.modules:
        # Threads of linear algebra, while they wait, would keep the cores busy for a tenth of a second.
        os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", TICKS)
    with below("mrs-simulator"), _ahead(name, argv[1:]):
        with loading():
            command = getattr(importlib.import_module("mrs_simulator." + module), function)
        command(argv[1:])


def _ahead(name, arguments):
    """Return a context in which what draws begins to load before what runs does, where ``name`` draws."""
    if name != "experiment":
        return contextlib.nullcontext()
    from mrs_simulator.study.draw.figure_process import ahead

    return ahead(arguments)


def _usage():
    """Return what the command can do, one line for each of ``COMMANDS``."""
    lines = ["usage: mrs-simulator COMMAND ...", "", __doc__.strip(), ""]
    lines += ["  {:16}{}".format(name, what) for name, (_, _, what) in COMMANDS.items()]
    return "\n".join(lines + ["", "mrs-simulator COMMAND --help lists its options."])


if __name__ == "__main__":
    main()
