"""Maps of three makers: their walls collide and are seen, and a bad one is refused by line or key."""

import math
import os

import numpy as np
import pytest

from mrs_simulator.protocols.making import make_control
from mrs_simulator.scenario.reading import ScenarioError
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.surroundings.maps import obstacles_of, rectangles, walls
from mrs_simulator.scenario.surroundings.obstacles import Box
from mrs_simulator.sensors.suite import Suite
from mrs_simulator.vehicles import Team
from mrs_simulator.vehicles.portable import portable, team_from_message
from mrs_simulator.world.contact.bodies import Bodies
from mrs_simulator.world.world import EVERY, World, WorldError

# A room of 6 x 4 cells with a wall all around, and a cell that stands out; the first row is the top.
ROOM = np.array([[1, 1, 1, 1, 1, 1], [1, 0, 0, 1, 0, 1], [1, 0, 0, 0, 0, 1], [1, 1, 1, 1, 1, 1]])
SERVED = "image: room.pgm\nresolution: 0.5\norigin: [-1.5, -1.0, 0.0]\nnegate: 0\n"
SERVED += "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
LINES = '2D-Map\nLineMinPos: 0 0\nNumLines: 2\nCairn: RobotHome 0 0 0 "" ICON ""\nLINES\n'
LINES += "2000 -3000 2000 3000\n-1000 3000 2000 3000\nDATA\n12 34\n"


def write_pgm(path, filled):
    pixels = np.where(filled, 0, 254).astype(np.uint8)
    head = "P5\n# made by hand\n{1} {0}\n255\n".format(*pixels.shape).encode()
    path.write_bytes(head + pixels.tobytes())


@pytest.fixture
def room(tmp_path):
    write_pgm(tmp_path / "room.pgm", ROOM)
    (tmp_path / "room.yaml").write_text(SERVED)
    (tmp_path / "office.map").write_text(LINES)
    return tmp_path


def scenario(room, **more):
    content = dict({"poses": [[0.25, -0.2, 0.0]], "kind": "epuck", "map": "room.yaml"}, **more)
    found = scenario_from_dict(content)
    return found._replace(map=found.map.located(str(room)))


def covered(boxes, x, y):
    return any(
        abs(box.x - x) < 0.5 * box.length and abs(box.y - y) < 0.5 * box.width for box in boxes
    )


def test_occupied_cells_of_map_server_become_boxes(room):
    boxes = obstacles_of(scenario(room))
    for row in range(4):
        for column in range(6):
            x, y = -1.5 + 0.5 * (column + 0.5), -1.0 + 0.5 * (3.5 - row)
            assert covered(boxes, x, y) == bool(ROOM[row, column]), (row, column)
    assert sum(box.length * box.width for box in boxes) == pytest.approx(0.25 * ROOM.sum())
    assert all(box.height == 0.5 for box in boxes)


def test_the_origin_of_a_map_may_be_turned(room):
    (room / "room.yaml").write_text(SERVED.replace("-1.0, 0.0]", "-1.0, 1.5707963267948966]"))
    boxes = obstacles_of(scenario(room))
    low, high = min(box.x for box in boxes), max(box.y for box in boxes)
    # What was along x from the corner (-1.5, -1) is along y, and what was along y is behind it.
    assert low == pytest.approx(-1.5 - 1.75) and high == pytest.approx(-1.0 + 2.75)
    assert all(box.yaw == pytest.approx(math.pi / 2.0) for box in boxes)


@pytest.mark.parametrize("more, count", [("negate: 1\n", 7), ("mode: raw\n", 0)])
def test_a_map_may_be_negated_or_raw(room, more, count):
    text = SERVED.replace("negate: 0\n", "") + more
    (room / "room.yaml").write_text(text)
    boxes = obstacles_of(scenario(room))
    assert sum(box.length * box.width for box in boxes) == pytest.approx(0.25 * count)


def test_a_bitmap_of_stage_is_scaled_to_its_size_about_its_middle(room):
    boxes = obstacles_of(scenario(room, map={"file": "room.pgm", "size": [12.0, 4.0]}))
    assert min(box.x - 0.5 * box.length for box in boxes) == pytest.approx(-6.0)
    assert max(box.y + 0.5 * box.width for box in boxes) == pytest.approx(2.0)
    assert covered(boxes, 1.0, 0.5) and not covered(boxes, 1.0, -0.5)  # the cell that stands out
    moved = {"file": "room.pgm", "size": [12.0, 4.0], "pose": [10.0, 0.0, 0.0], "height": 2.0}
    assert covered(obstacles_of(scenario(room, map=moved)), 11.0, 0.5)


def test_lines_of_mobilesim_become_walls(room):
    boxes = obstacles_of(scenario(room, map="office.map"))
    assert [(box.x, box.y) for box in boxes] == [(2.0, 0.0), (0.5, 3.0)]
    assert [box.length for box in boxes] == [6.0, 3.0]
    assert boxes[0].yaw == pytest.approx(math.pi / 2.0) and boxes[0].width == 0.02


def test_rectangles_cover_every_cell_once():
    filled = np.random.default_rng(2).random((40, 30)) < 0.6
    count = np.zeros(filled.shape, dtype=int)
    for low, high, left, right in rectangles(filled):
        count[low:high, left:right] += 1
    assert np.array_equal(count, filled)
    assert rectangles(np.ones((7, 5), dtype=bool)) == [[0, 7, 0, 5]]


def test_walls_of_a_map_collide_are_seen_and_are_known_to_laws(room):
    found = scenario(room, sensors=[{"mounts": {"ray": {
        "type": "laser", "rays": 1, "angles": [0, 0], "place": [0, 0, 0.05], "noise": {"stddev": 0},
    }}}])  # fmt: skip
    world = World.from_scenario(found)
    suite = Suite.of_scenario(found, Team.from_scenario(found), world.obstacles)
    suite.activate({0: ["ray"]})
    suite.update(0, world.sensed)
    assert suite.readings(0.0)[0]["ray"].ranges == pytest.approx([0.75])  # the wall begins at x = 1
    for _ in range(600):
        world.set_commands(EVERY, np.array([[0.12, 0.0]]))
        world.step()
    assert world.pose[0, 0] == pytest.approx(1.0 - 0.035, abs=1e-3)
    assert [collision.second[:3] for collision in world.contacts.take()] == ["map"]
    assert len(make_control(found).obstacles) == len(world.obstacles) > 3
    with pytest.raises(WorldError, match="robot1 overlaps obstacle map"):
        World.from_scenario(scenario(room, poses=[[1.1, 0.0, 0.0]]))


def test_many_obstacles_act_as_few_do():
    rng = np.random.default_rng(5)
    boxes = [Box("b{}".format(k), *rng.uniform(-6.0, 6.0, 2), k, 0.6, 0.3, 0.5) for k in range(60)]
    team = Team(("pioneer3dx",) * 9 + ("robotino3",) * 3)
    poses = np.column_stack([rng.uniform(-6.0, 6.0, (12, 2)), rng.uniform(-3.0, 3.0, 12)])
    together = Bodies(team, boxes)
    alone = [Bodies(team, [box]) for box in boxes]
    for _ in range(5):
        found = [(o.name, rows.tolist(), deep.tolist()) for o, rows, deep, _ in
                 together.obstacle_overlaps(poses)]  # fmt: skip
        each = [(o.name, rows.tolist(), deep.tolist()) for bodies in alone
                for o, rows, deep, _ in bodies.obstacle_overlaps(poses)]  # fmt: skip
        assert found == each and found
        room = together._room_to_move(poses)
        assert room == min(bodies._room_to_move(poses) for bodies in alone)
        poses[:, :2] += 0.1


def test_a_robot_beside_a_long_wall_is_as_far_from_it_as_it_is():
    """0.7 m beside a wall of 20 m at 30 deg it has that room, less its own reach."""
    yaw, away = np.pi / 6.0, 0.7
    wall = Box("wall", 1.0, 2.0, yaw, 20.0, 0.2, 0.5)
    bodies = Bodies(Team(("pioneer3dx",)), [wall])
    along, across = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    place = np.array([1.0, 2.0]) + 8.0 * along + (away + 0.1) * across
    pose = np.array([[*place, 0.0]])
    wanted = away - float(np.max(bodies.footprints.reach))
    assert bodies._room_to_move(pose) == pytest.approx(wanted, abs=1e-5)
    assert not list(bodies.obstacle_overlaps(pose))
    pose[0, :2] -= (away - 0.1) * across
    ((obstacle, rows, _, toward),) = bodies.obstacle_overlaps(pose)
    assert obstacle is wall and rows.tolist() == [0]
    np.testing.assert_allclose(toward, [-across], atol=1e-9)


def test_a_scenario_with_a_map_is_read_beside_its_file_and_published_without(room):
    (room / "run.yaml").write_text("poses: [[0.25, -0.2, 0.0]]\nkind: epuck\nmap: room.yaml\n")
    found = load_scenario(room / "run.yaml")
    assert found.map.file == str(room / "room.yaml")
    again = scenario_from_dict(found.to_dict())
    assert obstacles_of(again) == obstacles_of(found)
    told, _, _ = portable(found)
    assert told.map is None and told.obstacles == obstacles_of(found)
    assert team_from_message(told).n == 1
    with pytest.raises(ScenarioError, match="a file, wanted a kind's data: no file is opened"):
        team_from_message(found)


@pytest.mark.parametrize(
    "name, text, wanted",
    [
        (
            "room.yaml",
            SERVED.replace("0.5", "-1"),
            "room.yaml: resolution: -1, wanted a number above 0",
        ),
        ("room.yaml", SERVED + "trehshold: 1\n", "room.yaml: unknown 'trehshold'"),
        (
            "room.yaml",
            SERVED.replace("negate: 0", "negate: 2"),
            "room.yaml: negate: 2, wanted 0 or 1",
        ),
        (
            "room.yaml",
            SERVED.replace("[-1.5, -1.0, 0.0]", "[0, 0]"),
            "origin: .0, 0., wanted a list of 3",
        ),
        (
            "room.yaml",
            SERVED.replace("room.pgm", "rom.pgm"),
            "rom.pgm: no image that can be read: No such",
        ),
        (
            "room.yaml",
            SERVED.replace("room.pgm", "room.yaml"),
            "room.yaml: no image that can be read",
        ),
        (
            "office.map",
            LINES.replace("3000 2000 3000\nD", "3000 x 3000\nD"),
            "office.map, line 7: ",
        ),
        ("office.map", LINES.replace("NumLines: 2", "NumLines: 3"), "2 lines, but NumLines says 3"),
        ("office.map", "3D-Map\n", "office.map, line 1: '3D-Map', wanted 2D-Map"),
    ],
)
def test_a_bad_map_is_refused_by_its_line_or_key(room, name, text, wanted):
    (room / name).write_text(text)
    walls.cache_clear()
    with pytest.raises(ScenarioError, match=wanted):
        obstacles_of(scenario(room, map=name))


def test_an_image_that_unpacks_to_too_much_is_refused(room):
    (room / "room.pgm").write_bytes(b"P5\n99999 99999\n255\n" + bytes(9))
    with pytest.raises(ScenarioError, match="room.pgm: no image that can be read: Image size"):
        obstacles_of(scenario(room))


def test_a_wall_of_mobilesim_is_no_farther_than_a_floor_reaches(room):
    (room / "office.map").write_text(LINES.replace("-1000 3000", "-99999999999 3000"))
    with pytest.raises(ScenarioError, match="office.map, line 7: .*, of mm up to 1e"):
        obstacles_of(scenario(room, map="office.map"))


def test_a_map_that_is_too_large_is_refused_and_not_cut(room):
    with open(str(room / "office.map"), "r+") as file:
        file.truncate(64 * 1024 * 1024 + 1)
    with pytest.raises(ScenarioError, match="office.map: cannot be read: is larger than"):
        obstacles_of(scenario(room, map="office.map"))


def test_an_image_of_sixteen_bits_has_the_same_walls(room):
    found = obstacles_of(scenario(room))
    values = np.where(ROOM, 300, 65000).astype(">u2")
    (room / "room.pgm").write_bytes(b"P5\n6 4\n65535\n" + values.tobytes())
    assert obstacles_of(scenario(room)) == found


def test_an_image_that_is_drawn_anew_is_read_anew(room):
    before = obstacles_of(scenario(room))
    write_pgm(room / "room.pgm", 1 - ROOM)
    os.utime(room / "room.pgm", ns=(0, 0))
    assert obstacles_of(scenario(room)) != before


@pytest.mark.parametrize(
    "given, wanted",
    [
        ("room.bmpp", "map.file: 'room.bmpp', wanted a file that ends in .map, .yaml"),
        ({"file": "room.pgm"}, "map.size: nothing given, wanted a list of 2"),
        (
            {"file": "room.pgm", "size": [1.0, 0.0]},
            r"map.size\[1\]: 0.0, wanted a number above 0 \[m\]",
        ),
        ({"file": "room.yaml", "size": [1.0, 1.0]}, "map: unknown 'size'"),
        ({"file": "room.yaml", "hight": 1.0}, "map: unknown 'hight'; did you mean 'height'"),
        ({}, "map.file: nothing given"),
    ],
)
def test_an_impossible_map_is_refused_by_its_key(room, given, wanted):
    with pytest.raises(ScenarioError, match=wanted):
        scenario(room, map=given)
