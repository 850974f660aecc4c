"""Publishing at once: in order, to the last message, and never waiting for who does not read."""

import socket
import sys
import threading

import pytest
from ros_fixtures import PATIENCE, log_of, program, wait_until

from mrs_simulator.ros.nonblocking_publisher import NonblockingConnection


class Wire:
    """What NonblockingConnection needs of a rospy connection, over a pair of sockets."""

    name = "wire"

    def __init__(self):
        self.socket, self.far = socket.socketpair()
        self.done = False

    def fileno(self):
        return self.socket.fileno()

    def write_data(self, data):
        self.socket.sendall(data)

    def close(self):
        self.done = True
        self.socket.close()
        self.far.close()


@pytest.fixture
def wire():
    made = Wire()
    yield made
    made.close()


def read_all(wire, last):
    """Return the 100-byte messages that are there to be read until that of ``last``, as numbers."""
    wire.far.settimeout(PATIENCE)
    data = b""
    while not data.endswith(message(last)):
        data += wire.far.recv(65536)
    return [int(data[i : i + 100]) for i in range(0, len(data), 100)]


def message(number):
    return b"%100d" % number


def test_a_reader_gets_every_message_and_no_thread_is_made(wire):
    connection = NonblockingConnection(wire)
    for number in range(10):
        assert connection.write_data(message(number)) is not False
    assert read_all(wire, 9) == list(range(10)) and connection._thread is None


def test_who_does_not_read_is_not_waited_for_and_gets_the_newest_last(wire):
    wire.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
    connection = NonblockingConnection(wire)
    writer = threading.Thread(
        target=lambda: [connection.write_data(message(number)) for number in range(2000)],
        daemon=True,
    )
    writer.start()
    wait_until(lambda: not writer.is_alive())
    got = read_all(wire, 1999)
    assert got == sorted(got) and len(got) < 2000
    wait_until(lambda: not connection._late)
    connection.write_data(message(2000))
    assert read_all(wire, 2000) == [2000]


# Both with room for little: else megabytes go by before who writes to it is held up.
READER = """
import socket
import rospy
from nav_msgs.msg import Odometry

class Narrow(socket.socket):
    def connect(self, address):
        self.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        super().connect(address)

socket.socket = Narrow
rospy.init_node("reader", disable_rostime=True)
rospy.Subscriber("/robot1/odom", Odometry, lambda _: print("heard", flush=True))
rospy.rostime.wallsleep(1000)
"""
WRITER = """
import runpy, socket, sys
accept = socket.socket.accept

def narrow(listening):
    accepted, address = accept(listening)
    accepted.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
    return accepted, address

socket.socket.accept = narrow
del sys.argv[0]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def test_a_robot_that_stops_reading_holds_up_no_other(ros):
    """A subscriber that is stopped, as a driver that hangs: the stage goes on at its pace."""
    narrow = [sys.executable, "-c", WRITER, program("stage"), "--robots", "2"]
    stage = ros.start("stage", narrow)
    ros.node("pioneer_control", "--robots", 2)
    hung = ros.start("hung", [sys.executable, "-c", READER])
    probe = ros.probe()
    probe.ask("listen('/robot2/odom', Odometry)")
    probe.wait("odom(2)")
    wait_until(lambda: "heard" in log_of(hung))
    hung.send_signal(19)  # SIGSTOP
    try:
        before = probe.ask("now()")
        probe.wait("now() > {} + 2.0".format(before))
        assert stage.poll() is None
    finally:
        hung.send_signal(18)  # SIGCONT


def test_a_new_connection_begins_with_its_first_message(ros):
    said = ros.python(
        "import rospy\n"
        "from geometry_msgs.msg import Twist\n"
        "from mrs_simulator.ros.nonblocking_publisher import prompt_publisher\n"
        "rospy.init_node('first', disable_rostime=True)\n"
        "word = Twist()\n"
        "word.linear.x = 0.25\n"
        "publisher = prompt_publisher('/first', Twist, lambda: word)\n"
        "print(rospy.wait_for_message('/first', Twist, 20.0).linear.x)\n"
        "word = None\n"
        "heard = []\n"
        "kept = rospy.Subscriber('/first', Twist, heard.append)\n"
        "while not publisher.get_num_connections(): rospy.rostime.wallsleep(0.01)\n"
        "last = Twist()\n"
        "last.linear.x = 0.5\n"
        "while not heard: publisher.publish(last); rospy.rostime.wallsleep(0.01)\n"
        "print(heard[0].linear.x)\n"
    )
    assert said.split() == ["0.25", "0.5"]


def test_a_message_does_not_wait_until_the_one_before_is_acknowledged(ros):
    """Whatever the subscriber asks for: that of /clock, which rospy makes, asks for nothing."""
    said = ros.python(
        "import rospy, socket, time\n"
        "from std_msgs.msg import Empty\n"
        "from mrs_simulator.ros.nonblocking_publisher import prompt_publisher\n"
        "rospy.init_node('at_once', disable_rostime=True)\n"
        "publisher = prompt_publisher('/at_once', Empty)\n"
        "rospy.Subscriber('/at_once', Empty)\n"
        "while not publisher.get_num_connections(): time.sleep(0.01)\n"
        "(connection,) = publisher.impl.connections\n"
        "print(connection.socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))\n"
    )
    assert said.split() == ["1"]
