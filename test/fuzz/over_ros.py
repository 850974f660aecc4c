#!/usr/bin/env python3
"""Send a running stage and controller messages and requests of any kind, and see that they bear it.

    python3 test/fuzz/over_ros.py [--seconds 60] [--seed N]

Topics get messages with odd numbers and texts and with other types than they have, services odd
requests.  Both nodes must live, answer, print no traceback, and keep poses that are numbers; the team
is one of robots on the ground, in the air and on the water.
"""

import argparse
import contextlib
import os
import random
import re
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))

from ros_fixtures import Ros, log_of, wait_until  # noqa: E402

NUMBERS = [0.0, -1.0, 1e-300, 1e308, -1e308, float("nan"), float("inf"), 1e6, 3.0, 2.0**40]
TEXTS = [
    "",
    "pioneer3dx",
    "crazyflie2",
    "heron",
    "../../etc/passwd",
    "world",
    "x" * 5000,
    "\u202e",
    "a: &a [*a]",
    "nan",
]
TEAM = """
groups:
  - {number: 2, kind: pioneer3dx, poses: [[0, 0, 0], [0, 3, 0]]}
  - {number: 2, kind: crazyflie2, poses: [[5, 0, 0], [5, 3, 0]], altitude: 1.0}
  - {kind: heron, poses: [[20, 20, 0]]}
environment: {current: [0.1, 0.0], wind: {velocity: [2.0, 0.0], gusts: 0.5}}
control: {protocol: consensus}
duration: 1000
"""
PAUSE = 0.005  # [s] of wall time between two messages


def filled(draw, message, depth=0):
    """Return ``message`` with odd values in its fields."""
    for name, kind in zip(message.__slots__, message._slot_types):
        setattr(message, name, _value(draw, kind, getattr(message, name), depth))
    return message


def _value(draw, kind, now, depth):
    import genpy

    if kind.endswith("]"):
        inner = kind.partition("[")[0]
        fixed = kind.partition("[")[2][:-1]
        count = int(fixed) if fixed else draw.choice([0, 1, 2, 3, 50])
        return [_value(draw, inner, _new(inner), depth + 1) for _ in range(count)]
    if kind in ("float64", "float32"):
        value = draw.choice(NUMBERS + [draw.uniform(-5.0, 5.0)] * 5)
        return 1e30 if kind == "float32" and abs(value) > 1e38 else value
    if kind == "bool":
        return draw.random() < 0.5
    if kind == "string":
        return draw.choice(TEXTS)
    if kind in ("time", "duration"):
        return genpy.Time(draw.choice([0, 1, 5, 2**31]), draw.choice([0, 1, 999999999]))
    if re.match(r"u?int\d+$", kind):
        top = 2 ** (int("".join(filter(str.isdigit, kind))) - (not kind.startswith("u")))
        return draw.choice([0, 1, 2, 3, top - 1])
    return filled(draw, now, depth + 1)


def _new(kind):
    import roslib.message

    return roslib.message.get_message_class(kind)() if "/" in kind else None


def targets():
    """Return the topics with the types that they get, and the services with theirs."""
    from geometry_msgs.msg import Twist
    from nav_msgs.msg import Odometry
    from std_msgs.msg import Bool, String
    from std_srvs.srv import SetBool, Trigger

    from mrs_simulator.msg import TeamCommand, TeamOdometry
    from mrs_simulator.srv import SetSpeed, SetTeam, SetTopology, StepStage

    topics = [
        ("/robot1/cmd_vel", Twist),
        ("/robot1/odom", Odometry),
        ("/robot3/cmd_vel", Twist),  # in the air
        ("/robot3/odom", Odometry),
        ("/robot5/cmd_vel", Twist),  # on the water
        ("/stage/odometry", TeamOdometry),
        ("/robot2/cmd_vel", String),  # not what it is
        ("/stage/command", TeamCommand),
        ("/stage/answers", TeamCommand),
        ("/emergency_stop", Bool),
    ]
    services = [
        ("/stage/set_team", SetTeam),
        ("/stage/step", StepStage),
        ("/stage/pause", SetBool),
        ("/stage/pause_after", StepStage),
        ("/stage/reset", Trigger),
        ("/stage/set_speed", SetSpeed),
        ("/pioneer_control/set_topology", SetTopology),
        ("/pioneer_control/start", Trigger),
        ("/pioneer_control/stop", Trigger),
    ]
    return topics, services


def hostile(draw, seconds):
    """Send for ``seconds``; return how many messages and requests went out."""
    import rospy

    topics, services = targets()
    rospy.init_node("hostile", anonymous=True, disable_signals=True)
    publishers = [(rospy.Publisher(name, kind, queue_size=1), kind) for name, kind in topics]
    proxies = [(rospy.ServiceProxy(name, kind), kind) for name, kind in services]
    end, count = time.monotonic() + seconds, 0
    while time.monotonic() < end:
        if draw.random() < 0.9:
            publisher, kind = draw.choice(publishers)
            publisher.publish(filled(draw, kind()))
            time.sleep(PAUSE)
        else:
            proxy, kind = draw.choice(proxies)
            with contextlib.suppress(rospy.ServiceException, rospy.ROSException):  # a refusal
                proxy(filled(draw, kind._request_class()))
        count += 1
    with contextlib.suppress(rospy.ServiceException):  # what a person would do then
        rospy.ServiceProxy("/stage/set_speed", dict(services)["/stage/set_speed"])(1.0)
        rospy.ServiceProxy("/stage/pause", dict(services)["/stage/pause"])(False)
    return count


def trial(seconds, seed, directory):
    """Return ``(count, what was wrong)`` of ``seconds`` of hostile messages."""
    ros = Ros(directory)
    try:
        path = os.path.join(directory, "team.yaml")
        with open(path, "w") as file:
            file.write(TEAM)
        nodes = [ros.node(script, "--scenario", path) for script in ("stage", "pioneer_control")]
        probe = ros.probe()
        probe.wait("state('robot')")
        os.environ.update(ros.environment)
        count = hostile(random.Random(seed), seconds)
        return count, _judged(nodes, probe)
    finally:
        ros.close()


def _judged(nodes, probe):
    wrong = []
    for node in nodes:
        if node.poll() is not None:
            said = log_of(node)[-2000:]
            wrong.append("{} ended with {}:\n{}".format(node.log, node.poll(), said))
        # rospy itself prints one where the types of a topic differ.
        parts = re.findall(r"Traceback(?:.*\n)(?:  .*\n)*.*", log_of(node))
        wrong += ["a traceback:\n" + part for part in parts if "mrs_simulator" in part]
    if wrong:
        return wrong
    begin = probe.ask("now()")
    wait_until(lambda: probe.ask("now()") > begin)
    places = probe.ask("[state('x'), state('y'), state('theta'), state('z')]")
    if not all(value == value and abs(value) < 1e9 for row in places for value in row):
        wrong.append("poses {}".format(places))
    return wrong


def main():
    """Send what the command line says; exits with 1 if something was wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=int(time.time()))
    arguments = parser.parse_args()
    print("seed {}".format(arguments.seed))
    with tempfile.TemporaryDirectory(prefix="mrs_hostile_") as directory:
        count, wrong = trial(arguments.seconds, arguments.seed, directory)
    print("{} messages and requests, {}".format(count, "borne" if not wrong else "WRONG:"))
    print("\n".join(wrong))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
