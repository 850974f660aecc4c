"""A run in three dimensions: all of it is in view, and the same run gives the same picture."""

import os

import numpy as np
import pytest

from mrs_simulator.core.graphs import Topology
from mrs_simulator.core.spatial import upright
from mrs_simulator.pictures.camera import on_screen
from mrs_simulator.protocols.making import make_control
from mrs_simulator.record.recording import Run
from mrs_simulator.scenario.scenario import load_scenario, scenario_from_dict
from mrs_simulator.study.draw.animation import Animation, Stage
from mrs_simulator.study.draw.growing_curves import GrowingCurves
from mrs_simulator.study.draw.space_film import Film, SpaceStage, write_picture
from mrs_simulator.study.draw.style import LookError
from mrs_simulator.study.results.report import begin_run, control_of, read_run
from mrs_simulator.study.run.command import main as experiment

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOUR = os.path.join(ROOT, "scenarios", "paper_four.yaml")


def make_run(n=3, m=30, z=None):
    time = 0.2 * np.arange(m)
    pose = np.zeros((m, n, 3))
    pose[:, :, 0] = time[:, np.newaxis] + 5.0 * np.arange(n)
    pose[:, :, 1] = np.arange(n) ** 2
    spatial = None if z is None else upright(pose[..., 2], z * time[:, np.newaxis])
    hand, command = pose[..., :2].copy(), np.zeros((m, n, 2))
    return Run(time, np.arange(1, n + 1), pose, hand, command, spatial=spatial)


def test_the_whole_run_is_in_view():
    film = Film(make_run(z=0.5))
    camera = film.camera(300, 200)
    for row in (0, 15, 29):
        scene = film.scene(row)
        at = on_screen(camera.seen(scene.place), 300, 200)
        assert ((at > 0.0) & (at < (300.0, 200.0))).all()
        assert scene.place[0, 2] == pytest.approx(0.1 * row)
        assert [len(trail) for trail in scene.trails] == [row + 1] * 3


@pytest.mark.parametrize("kind", ["png", "pdf"])
def test_the_same_run_gives_the_same_picture(tmp_path, kind):
    paths = [str(tmp_path / (name + "." + kind)) for name in ("one", "two", "other")]
    for path, row in zip(paths, (-1, -1, 3)):
        write_picture(Film(make_run()), path, row=row, width=2.0)
    one, two, other = (open(path, "rb").read() for path in paths)
    assert one == two and one != other


def test_the_walls_of_a_map_are_shown(tmp_path):
    (tmp_path / "room.map").write_text("2D-Map\nNumLines: 1\nLINES\n0 9000 4000 9000\nDATA\n")
    (tmp_path / "room.yaml").write_text("poses: [[0, 0, 0]]\nmap: room.map\n")
    run = make_run()._replace(scenario=load_scenario(tmp_path / "room.yaml"))
    assert [wall.name for wall in Film(run).scene(0).obstacles] == ["map1"]


def test_an_animation_shows_the_run_in_space(tmp_path):
    run = make_run()
    animation = Animation(run, 0.5, 8.0, 2.0, stage=lambda run, width: SpaceStage(Film(run), width))
    first, *_, last = list(animation.frames())
    assert first.shape == (124, 200, 4) and (first != last).any()
    above = next(Animation(run, 0.5, 8.0, 2.0).frames())
    assert above.shape != first.shape or (above != first).any()


def test_obstacles_move_in_an_animation_from_above():
    cart = {"type": "box", "name": "cart", "center": [0.0, 3.0], "size": [1.0, 0.5]}
    ball = {"type": "cylinder", "name": "ball", "center": [2.0, 0.0], "radius": 0.3}
    track = {"to": [[4.0, 3.0]], "speed": 1.0}
    obstacles = [
        dict(cart, track=track),
        dict(ball, track={"to": [[2.0, 4.0]], "speed": 0.5}),
        dict(cart, name="wall", center=[5, 5]),
    ]
    run = make_run()
    scenario = scenario_from_dict({"poses": [[0, 0, 0]], "obstacles": obstacles})
    run = run._replace(scenario=scenario, meta=dict(run.meta, scene_time=0.5))
    stage = Stage(run, 2.0)
    box, circle = stage.show(0)[:2]
    assert box.get_xy()[:4].mean(axis=0) == pytest.approx([0.5, 3.0])
    assert stage.show(5)[:2] == (box, circle)
    time = 0.5 + run.time[5]
    assert box.get_xy()[:4].mean(axis=0) == pytest.approx([time, 3.0])
    assert circle.get_center() == pytest.approx((2.0, 0.5 * time))
    first, *_, last = Animation(run, 0.5, 8.0, 2.0).frames()
    assert (first != last).any()
    assert len(stage.moving) == 6  # the wall is drawn once


def test_edges_seen_from_above_join_the_points_that_the_law_moves():
    chain = Topology(4, [(2, 1, 1.0), (3, 2, 1.0), (4, 3, 1.0)])
    run = make_run(4)._replace(scenario=load_scenario(FOUR)._replace(topology=chain))
    run = run._replace(hand=run.hand + 0.5)
    (edges,) = (a.get_segments() for a in Stage(run, 2.0).show(7) if a.get_zorder() == 1.5)
    ends = {tuple(end) for edge in edges for end in np.round(edge, 6)}
    assert len(edges) == 3 and ends == {tuple(point) for point in np.round(run.hand[7], 6)}


def test_a_run_without_samples_is_refused():
    with pytest.raises(LookError, match="without samples"):
        Film(make_run(m=0))


def test_experiment_draws_graph_and_targets_of_the_protocol(tmp_path, capsys):
    out = str(tmp_path / "run")
    with pytest.raises(SystemExit):
        experiment([FOUR, "--duration", "2", "--out", out, "--formats", "", "--space"])
    assert "view.pdf" in capsys.readouterr().out
    assert {"view.png", "view.pdf"} <= set(os.listdir(out))
    run = read_run(out)
    scene = Film(run, control_of(run)).scene(-1)
    assert scene.targets.shape == (4, 3) and len(scene.edges) >= 3
    begin_run(run.scenario, out).close()
    assert not {"view.png", "view.pdf"} & set(os.listdir(out))  # of another run


def test_the_targets_of_a_march_go_on():
    scenario = load_scenario(os.path.join(ROOT, "scenarios", "marching.yaml"))
    film = Film(make_run(scenario.n), make_control(scenario))
    begin, end = (film.scene(row).targets for row in (0, -1))
    assert np.abs(end - begin).max() > 0.1


@pytest.mark.parametrize("n, z", [(3, None), (3, 0.5), (20, None)])
def test_curves_beside_the_team_grow_with_the_run(n, z):
    run = make_run(n, z=z)
    stage = GrowingCurves(run, 4.0, Stage)
    above = Stage(run, 2.0)
    pictures = [stage.picture(row) for row in (0, 15, 29)]
    height, width = pictures[0].shape[:2]
    assert width == 400 and height % 2 == 0
    np.testing.assert_array_equal(pictures[1][:, :200], above.picture(15)[:height])
    # What is drawn of the curves stays, and more comes at its right alone.
    columns = [
        np.flatnonzero((one != other).any(axis=(0, 2))) + 200
        for one, other in zip(np.array(pictures)[:-1, :, 200:], np.array(pictures)[1:, :, 200:])
    ]
    assert len(columns[0]) and len(columns[1]) and columns[0].max() < columns[1].min()
    stage.show(29)
    stage.figure.canvas.draw()
    shown = np.array(stage.figure.canvas.buffer_rgba())
    np.testing.assert_array_equal(shown, pictures[2])


def test_the_wheels_of_a_film_turn_as_far_as_the_robots_went():
    film = Film(make_run())
    first, last = film.scene(0).rolled, film.scene(-1).rolled
    assert not first.any() and last[:, 0] == pytest.approx(5.8)
