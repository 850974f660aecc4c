"""Fixtures that all tests share, and the choice of the quick ones and of one room's."""

from gui_fixtures import gui, no_hidden_errors  # noqa: F401
from rooms import ROOMS, room_of_test
from ros_fixtures import ros  # noqa: F401

# A test with one of these starts a ROS master or a GUI's process.
PROCESSES = {"ros", "gui"}


def pytest_addoption(parser):
    """Add ``--fast`` and ``--room``."""
    parser.addoption("--fast", action="store_true", help="only tests that start no ROS and no GUI")
    parser.addoption("--room", choices=ROOMS, help="only tests of modules in this room")


def pytest_collection_modifyitems(config, items):
    """Keep the tests that ``--fast`` and ``--room`` ask for."""
    fast, room = config.getoption("--fast"), config.getoption("--room")
    rooms = {item.path: room_of_test(str(item.path)) for item in items} if room else {}
    kept, left = [], []
    for item in items:
        slow = item.get_closest_marker("slow") or PROCESSES.intersection(item.fixturenames)
        wanted = not (fast and slow) and (not room or rooms[item.path] == room)
        (kept if wanted else left).append(item)
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = kept


def pytest_configure(config):
    """Describe the marker that takes a test out of ``--fast``."""
    config.addinivalue_line("markers", "slow: takes seconds, or starts programs: not with --fast")
