"""Experiments from Python: ``simulate``, what its runs give, animations and their commands."""

import io
import os
import shutil
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

from mrs_simulator import Parameter, PioneerControl, load_scenario, make_twist, open_run, simulate
from mrs_simulator.__main__ import main
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.draw.animation import Animation, Stage
from mrs_simulator.study.draw.style import LookError
from mrs_simulator.study.run.experiment import Experiment

STILL = {"robots": 2, "duration": 1.0, "poses": [[0, 0, 0], [3, 0, 0]]}


class Long(PioneerControl):
    """Points at rest, far ahead of the robots."""

    PARAMETERS = (Parameter("l", 0.4, "m", low=0.01),)

    def pointMassLaw(self, hand):
        return 0.0 * hand


class Ahead(PioneerControl):
    """Every robot drives straight on."""

    def calculateControlLaw(self, pos_map):
        return {number: make_twist(0.2, 0.0) for number in pos_map}


@pytest.fixture(scope="module")
def run():
    return simulate("consensus.yaml", duration=3.0)


def test_a_run_holds_arrays_and_verdict(run):
    assert run.run.pose.shape == (31, 6, 3) and run.prediction is not None
    assert run.verdict["ended"] == "complete" and run.passed == run.verdict["passed"]
    assert "Six points agree" in str(run) and run.verdict["outcome"] in repr(run)


def test_a_class_a_mapping_and_changes_are_taken():
    run = simulate(STILL, protocol=Ahead, seed=3, parameters={"l": 0.1})
    assert run.run.scenario.seed == 3 and run.run.scenario.hand_length == 0.1
    assert run.run.pose[-1, 0, 0] > 0.1
    with pytest.raises(ValueError, match="unknown|no parameter|gain"):
        simulate(STILL, protocol=Ahead, parameters={"gain": 1.0})
    with pytest.raises(ValueError, match="papr.yaml: no such file"):
        simulate("papr.yaml")


def test_the_laws_own_hand_length_is_recorded():
    run = simulate(STILL, protocol=Long).run
    np.testing.assert_allclose(run.hand[0], [[0.4, 0.0], [3.4, 0.0]])
    assert run.scenario.control.parameters == {"l": 0.4}


def test_the_table_has_the_numbers_of_the_file(run):
    pandas = pytest.importorskip("pandas")
    table = run.to_pandas()
    assert isinstance(table, pandas.DataFrame) and list(table.columns[:3]) == ["time", "robot", "x"]
    np.testing.assert_array_equal(table.x.values.reshape(31, 6), run.run.pose[:, :, 0])


def test_figures_are_new_or_on_given_axes(run):
    for figure in (run.trajectories(), run.states("y"), run.inputs(width="column")):
        assert isinstance(figure, Figure) and figure.axes
    assert run.inputs(width="column").get_figwidth() == 3.5
    figure = Figure()
    assert run.states(ax=figure.add_subplot(), style={"lines.linewidth": 3.0}) is figure
    with pytest.raises(LookError, match="width 'wide'"):
        run.trajectories(width="wide")


def test_a_run_is_kept_and_opened_again(tmp_path):
    run = simulate("consensus.yaml", out=tmp_path / "kept", duration=1.0)
    again = open_run(tmp_path / "kept")
    np.testing.assert_array_equal(again.run.pose, run.run.pose)
    assert again.verdict["checks"] == run.verdict["checks"]
    again.save(tmp_path / "more", formats=("svg",))
    assert (tmp_path / "more" / "trajectories.svg").exists()
    assert (tmp_path / "more" / "verdict.json").exists()


def test_a_temporary_directory_goes_with_its_run():
    run = simulate(STILL, protocol=Ahead)
    directory = run.directory
    assert os.path.exists(os.path.join(directory, "run.csv"))
    del run
    assert not os.path.exists(directory)


def test_samples_are_copies():
    experiment = Experiment(load_scenario(scenario_path("consensus.yaml")))
    samples = experiment.samples()
    _, pose, command = next(samples)
    begun = pose.copy()
    pose[:], command[:] = 1e6, 1e6
    np.testing.assert_array_equal(experiment.world.pose, begun)
    _, pose, _ = next(samples)
    assert np.abs(pose).max() < 1e3
    experiment.world.close()


def test_an_animation_shows_the_run(run):
    animation = Animation(run.run, seconds=0.5, rate=10.0, width=3.0)
    first, *_, last = animation.frames()
    assert len(animation.rows) == 5 and animation.rows[-1] == 30
    assert first.shape == last.shape and (first != last).any()
    gif = animation.gif()
    assert gif.startswith(b"GIF89a") and len(gif) < 100e3
    assert np.all(imread(io.BytesIO(gif), format="gif")[0, 0, :3] == 255)  # white, not nearly
    assert "data:image/gif;base64," in animation._repr_html_()
    assert gif == Animation(run.run, seconds=0.5, rate=10.0, width=3.0).gif()


def test_an_svg_moves_along_the_run(run, tmp_path):
    path = run.animate(seconds=2.0, width=3.0).save(str(tmp_path / "film.svg"))
    drawn = ElementTree.parse(path).getroot()
    (moving,) = (each for each in drawn if each.get("id") == "moving")
    moved = [each for each in moving.iter() if each.get("type") == "translate"]
    assert len(moved) == run.run.pose.shape[1]
    assert {each.get("dur") for each in moved} == {"2s"}
    stage = Stage(run.run, 3.0)
    for robot, each in enumerate(moved):
        keys = [float(key) for key in each.get("keyTimes").split(";")]
        places = [tuple(map(float, pair.split(","))) for pair in each.get("values").split(";")]
        assert len(keys) == len(places) and keys[0] == 0.0 and keys[-1] == 1.0
        for place, row in zip((places[0], places[-1]), (0, -1)):
            x, y = (
                stage.axes.transData.transform(run.run.pose[row, robot, :2])
                * 72.0
                / stage.figure.dpi
            )
            height = 72.0 * stage.figure.get_size_inches()[1]
            assert place == pytest.approx((x, height - y), abs=0.06)
    with open(path, "rb") as file:
        assert file.read() == run.animate(seconds=2.0, width=3.0).svg()


@pytest.mark.parametrize(
    "make, told",
    [
        (lambda a: a.save("film.avi"), "film.avi: wanted a file .gif, .svg or .mp4"),
        (lambda a: Animation(a.run, seconds=0.0), "0 s at 12 Hz, of 31 samples: wanted from 1"),
        (lambda a: Animation(a.run, seconds=float("nan")), "nan s"),
        (lambda a: Animation(a.run, stage=lambda run, width: None).svg(), "seen from above alone"),
    ],
)
def test_animations_that_cannot_be_had_are_named(run, make, told):
    with pytest.raises(LookError, match=told):
        make(run.animate())


def test_a_film_wants_ffmpeg(run, monkeypatch, tmp_path):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(LookError, match="ffmpeg is not installed; wanted it, or a file .gif"):
        run.animate().save(str(tmp_path / "film.mp4"))


def test_commands_write_animations_and_narrow_figures(tmp_path, capsys):
    out = str(tmp_path / "run")
    options = [
        "--duration",
        "1",
        "--formats",
        "png",
        "--width",
        "column",
        "--video",
        out + "/a.gif",
    ]
    with pytest.raises(SystemExit):
        main(["experiment", "consensus.yaml", "--out", out, *options])
    assert {"a.gif", "inputs.png"} < set(os.listdir(out)) and "inputs.pdf" not in os.listdir(out)
    os.remove(out + "/inputs.png")
    with pytest.raises(SystemExit):
        main(["report", out, "--formats", "svg", "--video", out + "/b.gif"])
    assert {"b.gif", "inputs.svg"} < set(os.listdir(out))
    main(["view", out, "--save", out + "/c.gif", "--speed", "1"])
    assert os.path.getsize(out + "/c.gif") > 1000
    wrong_curves = ["--beside-curves"], ["--video", "a.svg", "--beside-curves"]
    for wrong in (
        ["--video", "film.avi"],
        ["--width", "wide"],
        ["--formats", "bmp"],
        *wrong_curves,
    ):
        with pytest.raises(SystemExit) as ended:
            main(["report", out, *wrong])
        assert ended.value.code == 2
    said = capsys.readouterr().err
    assert "film.avi" in said and "--beside-curves: wanted --video" in said
