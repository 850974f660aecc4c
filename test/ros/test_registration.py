"""Nodes outlive their ROS master: one that comes in its place is told of them."""

import contextlib
import xmlrpc.client

from ros_fixtures import wait_until


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
