"""Stage and control on two hosts: network namespaces with a cable between them."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest
from forked import forker
from ros_fixtures import PATIENCE, STOP_LIMIT, Probe, log_of, log_settings, program, wait_until

TESTS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PROBE, ON_HOST = (os.path.join(TESTS, name + ".py") for name in ("ros_probe", "on_host"))
PORT = "11311"
LAN = "lan"  # name of each host's interface
START = "call('/pioneer_control/start', Trigger)"
DRIVE = "max(map(abs, state('vx') or [0])) > 0.1"
REST = "max(map(abs, state('vx') + state('omega'))) == 0.0"


class Host:
    """A network namespace with an address of its own, and the processes in it."""

    def __init__(self, name, address, directory):
        self.name, self.address, self.processes = name, address, []
        self._directory = directory
        self.environment = dict(
            os.environ,
            ROS_MASTER_URI="http://10.77.0.1:" + PORT,
            ROS_IP=address,
            ROS_LOG_DIR=str(directory / "ros"),
            PYTHONUNBUFFERED="1",
            ROS_PYTHON_LOG_CONFIG_FILE=log_settings(),
        )
        self.environment.pop("ROS_HOSTNAME", None)
        try:
            ip("netns", "add", name)
        except subprocess.CalledProcessError:
            # What is not permitted may leave its file behind all the same.
            subprocess.run(["ip", "netns", "del", name], timeout=STOP_LIMIT, stderr=subprocess.PIPE)
            raise
        ip("-n", name, "link", "set", "lo", "up")

    def start(self, name, script, *arguments):
        """Start a script of Python on this host; its output goes to a file."""
        log, given = (
            str(self._directory / (name + ".log")),
            [self.name, script, *map(str, arguments)],
        )
        process = forker().start(ON_HOST, given, self.environment, log, log)
        process.log = log
        self.processes.append(process)
        return process

    def probe(self):
        """Start a ``Probe`` on this host."""
        process = forker().start_piped(ON_HOST, self.environment, self.name, PROBE)
        self.processes.append(process)
        return Probe(process)

    def node(self, script, *arguments):
        """Start a node of the package."""
        return self.start(script, program(script), *arguments)

    def call(self, command, *arguments):
        """Run a command of ROS to its end; return its exit code."""
        return self.start("call", shutil.which(command), *arguments).wait(STOP_LIMIT)

    def cable(self, state):
        """Pull the cable, "down", or put it back, "up"."""
        ip("-n", self.name, "link", "set", LAN, state)

    def close(self):
        """End what runs here, and the host with it."""
        for process in reversed(self.processes):
            if process.poll() is None:
                process.kill()
                process.wait(STOP_LIMIT)
        ip("netns", "del", self.name)


def ip(*arguments):
    subprocess.run(["ip", *arguments], check=True, timeout=STOP_LIMIT, stderr=subprocess.PIPE)


@pytest.fixture
def hosts(tmp_path):
    """Two hosts with a cable between them; on the first a master and a stage of four robots."""
    if shutil.which("ip") is None:
        pytest.skip("no command ip (package iproute2)")
    made, names = [], ("mrs{}a".format(os.getpid()), "mrs{}b".format(os.getpid()))
    try:
        try:
            for name, address in zip(names, ("10.77.0.1", "10.77.0.2")):
                made.append(Host(name, address, tmp_path))
            ends = ["netns", names[0], "type", "veth", "peer", "name", LAN, "netns", names[1]]
            ip("link", "add", LAN, *ends)
        except subprocess.CalledProcessError as error:
            pytest.skip("network namespaces: " + error.stderr.decode().strip())
        for host in made:
            ip("-n", host.name, "address", "add", host.address + "/24", "dev", LAN)
            host.cable("up")
        made[0].master = made[0].start("master", shutil.which("rosmaster"), "--core", "-p", PORT)
        use_clock = ["rosparam", "set", "/use_sim_time", "true"]
        wait_until(lambda: made[0].call(*use_clock) == 0)
        made[0].node("stage", "--robots", 4)
        yield made
    finally:
        for host in made:
            host.close()


def test_a_cut_link_stops_the_robots_and_they_go_on_when_asked_to(hosts):
    control = hosts[1].node("pioneer_control", "--robots", 4, "_resume:=false")
    probe = hosts[0].probe()
    for end in hosts:  # whichever host loses its cable
        probe.wait(DRIVE)
        # Slowly: the latency of this test's own looks is then short in simulated time.
        assert probe.ask("call('/stage/set_speed', SetSpeed, 0.25)")[0]
        probe.wait("status('speed') == 0.25")
        end.cable("down")
        cut = probe.ask("now()")
        stopped = probe.wait("not any(state('commanded')) and stamp()")
        # The bound is the watchdog's 0.6 s of simulated time, and that latency.
        assert stopped - cut < 0.6 + 0.5
        assert probe.ask("call('/stage/set_speed', SetSpeed, 1.0)")[0]
        probe.wait(REST)
        said = wait_until(lambda: "robots stopped: " in log_of(control) and log_of(control))
        assert "/clock is silent" in said or "no fresh odometry of robot1" in said
        os.truncate(control.log, 0)
        end.cable("up")
        probe.wait("'then call the service /pioneer_control/start' in control('trouble')")
        # It hears the robots again, and lets them stand.
        probe.wait("control('stale') == [] and control('running') is False")
        probe.wait_simulated(0.5)
        assert probe.ask(REST)
        assert wait_until(lambda: probe.ask(START)[0])
    probe.wait(DRIVE)


def test_left_alone_they_go_on_in_the_simulator(hosts):
    hosts[1].node("pioneer_control", "--robots", 4)
    probe = hosts[0].probe()
    probe.wait(DRIVE)
    hosts[1].cable("down")
    probe.wait(REST)
    hosts[1].cable("up")
    probe.wait(DRIVE)


def test_without_a_master_the_robots_still_obey_the_control_node(hosts):
    control = hosts[1].node("pioneer_control", "--robots", 4)
    probe = hosts[0].probe()
    probe.wait(DRIVE)
    hosts[0].master.kill()
    hosts[0].master.wait(STOP_LIMIT)
    probe.wait_simulated(1.0)
    assert probe.ask(DRIVE)
    control.send_signal(signal.SIGINT)
    probe.wait(REST)
    assert control.wait(PATIENCE) == 0


def test_the_control_node_ends_though_its_master_is_out_of_reach(hosts):
    control = hosts[1].node("pioneer_control", "--robots", 4)
    wait_until(lambda: "running" in log_of(control))
    hosts[0].cable("down")
    wait_until(lambda: "robots stopped" in log_of(control))
    time.sleep(0.5)  # its log messages do not wait for the master either
    control.send_signal(signal.SIGINT)
    assert control.wait(PATIENCE) == 0


def test_the_documented_launch_file_is_one(tmp_path):
    page = os.path.join(os.path.dirname(PROBE), "..", "docs", "robots.md")
    with open(page, encoding="utf-8") as file:
        (text,) = re.findall(r"```xml\n(.*?)```", file.read(), re.S)
    (tmp_path / "lab.launch").write_text(text)
    code = "import roslaunch.config, sys; c = roslaunch.config.load_config_default([sys.argv[1]], None)"
    code += "; print(sorted((n.namespace + n.name, n.machine.address) for n in c.nodes))"
    command = [sys.executable, "-c", code, str(tmp_path / "lab.launch")]
    said = subprocess.run(command, check=True, timeout=60, stdout=subprocess.PIPE).stdout.decode()
    places = [("/pioneer_control", "localhost")]
    places += [("/robot{}/RosAria".format(n), "192.168.1.2{}".format(n)) for n in (1, 2)]
    assert said.strip().endswith(str(places))
