"""What a ROS master knows of nodes: all of those that outlived the one before it, none that has ended."""

import contextlib
import signal
import xmlrpc.client

from ros_fixtures import STOP_LIMIT, wait_until

OF_ROSPY = {"/clock", "/rosout"}  # topics that each node has before it can be asked to end


def test_after_the_master_was_restarted_stop_reaches_the_controller_again(ros):
    ros.node("stage", "--robots", 2)
    ros.node("pioneer_control", "--robots", 2)
    probe = ros.probe()
    probe.wait("state('command_v') is not None and any(state('command_v'))")
    ros.master.kill()
    ros.master.wait()
    ros.start("master_again", ["rosmaster", "--core", "-p", ros.uri.rpartition(":")[2]])
    master = xmlrpc.client.ServerProxy(ros.uri)

    def known():
        with contextlib.suppress(OSError):
            return all(
                master.lookupService("/test", name)[0] == 1
                for name in ("/pioneer_control/stop", "/stage/pause")
            )

    wait_until(known)
    answer = ros.call("rosservice", "call", "/pioneer_control/stop")
    assert "zero commands sent" in answer
    wait_until(lambda: master.getParam("/test", "/use_sim_time")[2] is True)
    published = "/stage/state", ["/stage"]
    wait_until(lambda: published in map(tuple, master.getSystemState("/test")[2][0]))


def test_a_node_that_has_ended_leaves_nothing_at_the_master(ros, tmp_path):
    # or the master would tell whoever has its address then to end, once a node of its name comes again
    team, ends = ("--robots", 2), (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    master = xmlrpc.client.ServerProxy(ros.uri)
    master.setParam("/test", "/markers/v_mx", 0.2)  # which it warns of as it starts
    running = {
        "/stage": ros.node("stage", *team),
        "/pioneer_control": ros.node("pioneer_control", *team),
        "/record": ros.node("record", *team, "--out", tmp_path),
        "/markers": ros.node("markers"),
        "/camera": ros.node("camera"),
    }
    ros.node("preflight", *team).wait(STOP_LIMIT)  # ends by itself

    def begun():
        topics = [each for kind in master.getSystemState("/test")[2][:2] for each in kind]
        return {name for topic, names in topics if topic not in OF_ROSPY for name in names}

    wait_until(lambda: begun() >= running.keys())
    for number, node in enumerate(running.values()):
        node.send_signal(ends[number % len(ends)])
    for node in running.values():
        node.wait(STOP_LIMIT)
    kept = [name for name in [*running, "/preflight"] if master.lookupNode("/test", name)[0] == 1]
    assert kept == []
