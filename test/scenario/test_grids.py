"""A scene as a grid of cells, and the grid that a driven robot's scans make of it."""

import numpy as np
import pytest
import yaml
from documentation import loaded

from mrs_simulator.control.pioneer_control import PioneerControl
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.scenario.surroundings.grids import Grid, scene_grid
from mrs_simulator.scenario.surroundings.maps import FLOOR, UNKNOWN, WALL
from mrs_simulator.study.run.experiment import Experiment

AWAY = [9.0, 9.0, 0.0]
ROOM = [  # 8 m by 6 m, with a box and a column in it
    {"type": "box", "name": "south", "center": [4.0, -0.1], "size": [8.4, 0.2]},
    {"type": "box", "name": "north", "center": [4.0, 6.1], "size": [8.4, 0.2]},
    {"type": "box", "name": "west", "center": [-0.1, 3.0], "size": [0.2, 6.4]},
    {"type": "box", "name": "east", "center": [8.1, 3.0], "size": [0.2, 6.4]},
    {"type": "box", "name": "shelf", "center": [5.0, 4.5], "size": [1.0, 0.4], "yaw": 0.5},
    {"type": "cylinder", "name": "post", "center": [2.5, 1.2], "radius": 0.3},
]


@pytest.fixture(scope="module")
def mapping():
    return loaded("benchmarks", "mapping")


class Rounds(PioneerControl):
    """Drives a circle, keeping every scan and where it was taken."""

    SENSORS = ("laser",)

    def calculateControlLaw(self, pos_map):
        from mrs_simulator import make_twist

        self.__dict__.setdefault("kept", {})
        laser = self.readings[1].laser
        self.kept.setdefault(laser.stamp, (pos_map[1], laser))
        return {1: make_twist(0.7, 0.7)}


def test_a_scene_is_drawn_cell_by_cell():
    box = {"type": "box", "name": "a", "center": [0.5, 0.25], "size": [1.0, 0.5]}
    far = {"type": "cylinder", "name": "b", "center": [3.0, 2.0], "radius": 0.5}
    grid = scene_grid(scenario_from_dict({"poses": [AWAY], "obstacles": [box, far]}))
    assert grid.side == 0.05 and grid.origin == pytest.approx((-1.0, -1.0, 0.0))
    places = grid.places()[grid.cells == WALL]
    inside = (np.abs(places - [0.5, 0.25]) < [0.5, 0.25]).all(axis=1)
    assert inside.sum() == 20 * 10  # cells of 1 m by 0.5 m
    disc = np.hypot(*(places - [3.0, 2.0]).T) < 0.525
    assert len(places) == inside.sum() + disc.sum()
    assert disc.sum() * 0.05**2 == pytest.approx(np.pi * 0.525**2, rel=0.05)
    row, column = grid.rows_columns([0.5, 0.25])
    assert grid.cells[row, column] == WALL and grid.holds(row, column)
    assert not grid.holds(*grid.rows_columns([9.0, 0.0]))
    assert scene_grid(scenario_from_dict({"poses": [AWAY]})) is None


def test_a_served_map_keeps_its_cells(tmp_path):
    values = np.full((4, 6), 254, dtype=np.uint8)
    values[0, :2], values[3, 5] = 0, 205  # a wall on top, and something unknown at the lower right
    (tmp_path / "m.pgm").write_bytes(b"P5\n6 4\n255\n" + values.tobytes())
    served = {"image": "m.pgm", "resolution": 0.5, "origin": [1.0, 2.0, 0.0]}
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(served))
    scene = {"poses": [[20.0, 0.0, 0.0]], "map": {"file": "m.yaml", "pose": [0.0, 0.0, np.pi / 2]}}
    (tmp_path / "s.yaml").write_text(yaml.safe_dump(scene))
    grid = scene_grid(load_scenario(str(tmp_path / "s.yaml")))
    assert grid.side == 0.5 and grid.origin == pytest.approx((-2.0, 1.0, np.pi / 2))
    assert grid.cells.shape == (4, 6) and (grid.cells[3, :2] == WALL).all()
    assert grid.cells[0, 5] == UNKNOWN and (grid.cells == FLOOR).sum() == 21
    # The lower left cell's centre, a quarter turn about the common origin.
    assert grid.places()[0, 0] == pytest.approx([-2.25, 1.25])
    assert tuple(map(int, grid.rows_columns([-2.25, 1.25]))) == (0, 0)


def test_scans_laid_over_each_other_by_known_poses_are_the_map(mapping):
    content = {
        "poses": [[4.0, 1.7, 0.0]],
        "obstacles": ROOM,
        "duration": 9.0,
        "sensors": [{"mounts": {"laser": {"range": [0.1, 10.0]}}}],
        "limits": "top",
    }
    scenario = scenario_from_dict(content)
    experiment = Experiment(scenario, Rounds)
    for _ in experiment.samples():
        pass
    wanted = scene_grid(scenario)
    scans = list(experiment.control.kept.values())
    assert len(scans) == 91 and not experiment.collisions
    found = mapping.scanned_grid(wanted, scans)
    invented, crossed = mapping.disagreement(found, wanted)
    assert invented == 0.0 and crossed < 2e-3  # rays that graze a corner cross the cell beside it
    seen = found.cells == WALL
    assert seen.sum() > 400  # most of 28 m of walls, 20 cells a metre
    # Scans laid by poses that are 15 cm off are another map.
    wrong = [((x + 0.15, y, theta), scan) for (x, y, theta), scan in scans]
    assert mapping.disagreement(mapping.scanned_grid(wanted, wrong), wanted)[0] > 0.1


def test_lost_rays_say_nothing_and_rays_that_meet_nothing_free_their_way(mapping):
    from mrs_simulator.sensors.types.ranging import RangeReading

    places = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, np.pi / 2]])
    grid = Grid(np.zeros((20, 20), dtype=np.int8), 0.1, (-1.0, -1.0, 0.0))
    reading = RangeReading(0.0, np.array([np.inf, np.nan]), places, 0.5)
    found = mapping.scanned_grid(grid, [((0.05, 0.05, 0.0), reading)]).cells
    assert (found[10, 10:14] == FLOOR).all() and (found == FLOOR).sum() <= 6
    assert not (found == WALL).any()
