"""Sweeps: axes, one table, one figure, and an interrupted sweep that resumes."""

import contextlib
import csv
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import yaml
from ros_fixtures import wait_until

from mrs_simulator.core import compiling
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import scenario_path
from mrs_simulator.study.results.provenance import read_provenance
from mrs_simulator.study.results.report import read_run
from mrs_simulator.study.results.reproduce import SAME, reproduce
from mrs_simulator.study.run import command, run_keys, sweep, workers
from mrs_simulator.study.run.command import main, sweep_main
from mrs_simulator.study.run.experiment import run_experiment
from mrs_simulator.study.run.run_keys import law_files
from mrs_simulator.study.run.sweep import (
    PROTOCOL,
    SweepError,
    make_runs,
    read_axis,
    run_sweep,
    summary,
)
from mrs_simulator.study.run.workers import Cores, failed, on_cores

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOUR = os.path.join(ROOT, "scenarios", "paper_four.yaml")
PAPER = os.path.join(ROOT, "scenarios", "paper.yaml")
K = "control.parameters.k"


@pytest.mark.parametrize(
    "text, expected",
    [
        ("seed=0..3", ("seed", [0, 1, 2, 3])),
        (K + "=0.01, 0.02", (K, [0.01, 0.02])),
        (
            "poses={layout: line},{layout: grid}",
            ("poses", [{"layout": "line"}, {"layout": "grid"}]),
        ),
        ("fidelity=kinematic", ("fidelity", ["kinematic"])),
        ("duration=1e2,1e-3", ("duration", [100.0, 0.001])),
    ],
)
def test_axes(text, expected):
    assert read_axis(text) == expected


@pytest.mark.parametrize("text", ["seed", "=3", "seed=", "seed=9..2", "k=[1"])
def test_bad_axes_are_refused(text):
    with pytest.raises(SweepError):
        read_axis(text)


def test_a_value_that_is_no_scenarios_is_refused_as_in_a_run(tmp_path):
    path = tmp_path / "dated.yaml"
    path.write_text("title: 2024-05-01\nposes: [[0, 0, 0]]\n")
    with pytest.raises(ValueError, match="title: datetime.date.*, wanted a text"):
        make_runs(str(path), [("seed", [0])])


def test_an_impossible_combination_is_refused_before_anything_runs():
    with pytest.raises(ValueError, match="duration: -1"):
        make_runs(FOUR, [("duration", [1.0, -1])])
    with pytest.raises(ValueError, match="unknown 'colour'"):
        make_runs(FOUR, [("colour", [1])])
    with pytest.raises(ValueError, match="k: wanted control.parameters.k, a parameter of the law"):
        make_runs(FOUR, [("k", [1.0])])


@pytest.fixture
def undrawn(monkeypatch):
    """Let sweeps find nothing to draw, where no figure is looked at: most of the time of a small one."""
    monkeypatch.setattr("mrs_simulator.study.draw.sweep_figures.sweep_figure", lambda *_: None)


def rows(out):
    with open(os.path.join(out, "sweep.csv"), newline="") as file:
        return list(csv.DictReader(file))


def test_a_sweep_in_parallel_gives_a_table_and_a_figure(tmp_path):
    runs = make_runs(FOUR, [(K, [0.02, 0.05]), ("seed", [0, 1]), ("duration", [40.0])])
    verdicts = run_sweep(runs, str(tmp_path), jobs=2)
    assert [verdict["ended"] for verdict in verdicts] == ["complete"] * 4
    table = rows(str(tmp_path))
    assert [(row[K], row["seed"]) for row in table] == [
        ("0.02", "0"), ("0.02", "1"), ("0.05", "0"), ("0.05", "1")
    ]  # fmt: skip
    assert float(table[0]["settle_time"]) == pytest.approx(35.4, abs=0.2)
    assert float(table[2]["settle_time"]) < float(table[0]["settle_time"])
    assert (tmp_path / "sweep.pdf").exists()


def test_a_law_that_was_edited_is_run_again(tmp_path):
    law = tmp_path / "law.py"
    text = (
        "from mrs_simulator import PioneerControl\n\n\nclass Law(PioneerControl):\n"
        "    def pointMassLaw(self, hand):\n        return 0.0 * hand\n"
    )
    names = []
    for added in ("", "\n\n# another\n", ""):
        law.write_text(text + added)
        ((name, _, _),) = make_runs(FOUR, [("seed", [1])], {PROTOCOL: str(law)})
        names.append(name)
    assert names[0] == names[2] != names[1]


def test_modules_that_a_law_imports_are_in_the_key(tmp_path, monkeypatch):
    library, laws = tmp_path / "library", tmp_path / "laws"
    for directory in (library / "tools", laws):
        directory.mkdir(parents=True)
    monkeypatch.syspath_prepend(str(library))
    law = laws / "law.py"
    law.write_text(
        "from mrs_simulator import PioneerControl\nimport gains\n\n\nclass Law(PioneerControl):\n"
        "    def pointMassLaw(self, hand):\n        from tools import late\n"
        "        return -gains.K * hand * late.SHARE\n"
    )
    files = {laws / "gains.py": "from numbers_of_mine import K\n", laws / "numbers_of_mine.py": ""}
    files.update({library / "tools" / "__init__.py": "from . import deep\n"})
    files.update({library / "tools" / "late.py": "SHARE = 1.0\n"})
    files.update({library / "tools" / "deep.py": "", library / "law_by_name.py": law.read_text()})
    for path, text in files.items():
        path.write_text(text + "\n")
    (laws / "numbers_of_mine.py").write_text("K = 1.0\n")
    (laws / "unused.py").write_text("")
    assert set(law_files(str(law))) == {str(law), *map(str, files)} - {
        str(library / "law_by_name.py")
    }
    assert str(library / "law_by_name.py") in law_files("law_by_name:Law")
    assert law_files("formation") == []

    def names(protocol):
        return [name for name, _, _ in make_runs(FOUR, [("seed", [1])], {PROTOCOL: protocol})]

    for protocol in (str(law), "law_by_name:Law"):
        known = [names(protocol)]
        for path in [*files, law] if protocol == str(law) else [library / "law_by_name.py"]:
            path.write_text(path.read_text() + "\n# changed\n")
            known.append(names(protocol))
        assert len({tuple(each) for each in known}) == len(known) - (protocol == str(law))
        assert names(protocol) == known[-1]
    (laws / "unused.py").write_text("changed\n")
    assert names(str(law)) == names(str(law))


def test_the_package_and_what_computes_are_in_the_key(tmp_path, monkeypatch):
    def name():
        run_keys._computing.cache_clear()
        ((name, _, _),) = make_runs(FOUR, [("seed", [1])])
        return name

    (tmp_path / "core").mkdir()
    source = tmp_path / "core" / "a.py"
    source.write_text("a = 1\n")
    monkeypatch.setattr(run_keys, "PACKAGE", str(tmp_path))
    known = [name()]
    (tmp_path / "core" / "__pycache__").mkdir()
    (tmp_path / "core" / "__pycache__" / "a.push-1.py311.nbi").write_text("kept by numba")
    assert known[0] == name()
    source.write_text("a = 2\n")
    known.append(name())
    for package in ("mrs_simulator", "pybullet"):
        told = dict(run_keys.versions(), **{package: "another"})
        monkeypatch.setattr(run_keys, "versions", lambda told=told: told)
        known.append(name())
    run_keys._computing.cache_clear()
    assert len(set(known)) == 4


def test_a_number_of_robots_changes_a_list_of_poses_as_in_a_run(tmp_path, capsys):
    paper = scenario_path("paper")
    runs = make_runs(paper, [("robots", [3, 7, 9])])
    base = load_scenario(paper)
    for (_, _, scenario), n in zip(runs, (3, 7, 9)):
        assert scenario.to_yaml() == base.overridden(robots=n).to_yaml()
    # A layout is laid out anew for each number.
    path = tmp_path / "s.yaml"
    path.write_text("robots: 3\nposes: {layout: circle, radius: 3.0}\n")
    for n, (_, _, scenario) in zip((3, 5), make_runs(str(path), [("robots", [3, 5])])):
        assert scenario.n == n and np.ptp(np.hypot(*scenario.poses[:, :2].T)) < 1e-9
    with pytest.raises(SystemExit) as ended:
        sweep_main([paper, "seed=1", "--robots", "8", "--duration", "0.1", "--out", str(tmp_path)])
    said = capsys.readouterr()
    assert ended.value.code != 2 and "robot8 is not in the scenario: put where" in said.err
    assert "1 runs" in said.out


def test_another_fidelity_needs_no_engine(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text("poses: [[0, 0, 0]]\nfidelity: dynamic\nengine: planar\n")
    for given in ({"fidelity": "kinematic"}, {}):
        axes = [("seed", [1])] if given else [("fidelity", ["kinematic", "dynamic"])]
        (_, _, scenario), *_ = make_runs(str(path), axes, given)
        assert scenario.fidelity == "kinematic"


def test_a_map_or_kind_that_was_edited_is_run_again(tmp_path):
    room, slow = tmp_path / "room.map", tmp_path / "slow.yaml"
    path = tmp_path / "s.yaml"
    path.write_text("poses: [[0, 0, 0]]\nmap: room.map\nkind: slow.yaml\n")

    def name(far, speed):
        room.write_text("2D-Map\nLINES\n{0} 0 {0} 1000\nDATA\n".format(far))
        limits = "{{firmware: {{linear.x: {{max: {} m/s}}}}}}".format(speed)
        slow.write_text("base: pioneer3dx\nlimits: {}\n".format(limits))
        ((name, _, _),) = make_runs(str(path), [("seed", [1])])
        return name

    first = name(4000, 0.2)
    assert len({first, name(5000, 0.2), name(4000, 0.3)}) == 3 and name(4000, 0.2) == first


def test_entries_of_lists_are_swept(tmp_path):
    path, key = tmp_path / "s.yaml", "sensors[0].mounts.gps.noise.stddev"
    path.write_text("poses: [[0, 0, 0]]\nsensors: [{mounts: {gps: {type: gps}}}]\n")
    runs = make_runs(str(path), [(key, [0.1, 0.2]), ("poses[0][1]", [3])])
    told = [run.sensors[0].mounts["gps"]["noise"]["stddev"] for _, _, run in runs]
    assert told == [0.1, 0.2] and runs[0][2].poses[0].tolist() == [0.0, 3.0, 0.0]
    for wrong in (
        "sensors[1].mounts",
        "sensors[x].mounts",
        "seed[0].mounts",
        "sensors[0",
        "sensors[]",
    ):
        with pytest.raises(SweepError, match="no entry of a list"):
            make_runs(str(path), [(wrong, [1])])


@pytest.mark.usefixtures("undrawn")
def test_runs_alike_are_run_once(tmp_path, monkeypatch):
    ran = []

    def run(scenario, out, many):
        ran.append(out)
        return sweep.failed("as told")

    monkeypatch.setattr(sweep, "_guarded_run", run)
    monkeypatch.setattr(
        sweep, "on_cores", lambda run, tasks, jobs: enumerate(run(*t) for t in tasks)
    )
    runs = make_runs(FOUR, [("seed", [1, 2, 1]), ("duration", [1.0])])
    verdicts = run_sweep(runs, str(tmp_path), jobs=2)
    assert len(ran) == 2 and len(verdicts) == 3 and None not in verdicts
    assert [row["seed"] for row in rows(str(tmp_path))] == ["1", "2", "1"]


def test_scenarios_of_a_long_sweep_are_put_into_yaml_once(monkeypatch):
    runs = make_runs(scenario_path("paper"), [read_axis("control.parameters.k=0.01..0.02/1000")])
    monkeypatch.setattr(yaml, "safe_dump", None)
    texts = {scenario.to_yaml() for _, _, scenario in runs}
    assert len(texts) == len(runs)


def test_many_runs_pay_together_and_few_do_not(monkeypatch):
    pytest.importorskip("numba")
    monkeypatch.delenv(compiling.VARIABLE, raising=False)
    assert not sweep._are_many(make_runs(PAPER, [("duration", [3.0, 3.1])]))
    assert sweep._are_many(10 * make_runs(PAPER, [("seed", [1])]))


@pytest.mark.release  # compiling takes long
@pytest.mark.usefixtures("undrawn")
def test_runs_that_pay_together_are_compiled_and_reproduced_so(tmp_path, monkeypatch, capsys):
    pytest.importorskip("numba")
    monkeypatch.delenv(compiling.VARIABLE, raising=False)
    runs = make_runs(PAPER, [("duration", [3.0, 3.1])])
    monkeypatch.setattr(sweep, "_are_many", lambda runs: True)
    run_sweep(runs, str(tmp_path), jobs=1)
    run = str(tmp_path / runs[0][0])
    assert read_provenance(run)["compiled"] == "many"
    assert reproduce(run) == SAME
    with compiling.chosen("0"):
        run_experiment(runs[0][2], str(tmp_path / "plain"), formats=())
    plain, own = (read_run(each) for each in (str(tmp_path / "plain"), run))
    assert not np.array_equal(plain.pose, own.pose)
    np.testing.assert_allclose(plain.pose, own.pose, rtol=0.0, atol=1e-9)


def test_without_numba_a_sweep_says_what_that_costs(monkeypatch, capsys):
    monkeypatch.delenv(compiling.VARIABLE, raising=False)
    monkeypatch.setattr(compiling, "find_spec", lambda name: None)
    assert not sweep._are_many(100 * make_runs(PAPER, [("seed", [1])]))
    said = capsys.readouterr().err
    assert said.startswith("sweep: numba is not installed: these runs take some 1")


@pytest.mark.usefixtures("undrawn")
def test_what_was_finished_is_not_run_again(tmp_path):
    runs = make_runs(FOUR, [("seed", [0, 1]), ("duration", [1.0])])
    run_sweep(runs[:1], str(tmp_path), jobs=1)
    done = tmp_path / runs[0][0] / "run.csv"
    stamp = done.stat().st_mtime_ns
    run_sweep(runs, str(tmp_path), jobs=1)
    assert done.stat().st_mtime_ns == stamp
    assert len(rows(str(tmp_path))) == 2


def test_parts_of_a_sweep_are_taken_together(tmp_path, monkeypatch):
    runs = make_runs(FOUR, [("seed", [0, 1, 2]), ("duration", [1.0])])
    told = []
    for part in ((2, 2), (1, 2)):
        told += run_sweep(runs, str(tmp_path), jobs=1, part=part)
    assert not (tmp_path / "sweep.csv").exists() and not (tmp_path / "sweep.png").exists()
    parts = [(tmp_path / sweep.table_name((i, 2))).read_text().splitlines() for i in (1, 2)]
    assert [len(lines) for lines in parts] == [3, 2]
    monkeypatch.setattr(sweep, "run_experiment", None)  # nothing is left to run
    run_sweep(runs, str(tmp_path), jobs=1)
    whole = (tmp_path / "sweep.csv").read_text().splitlines()
    assert whole == [parts[0][0], parts[0][1], parts[1][1], parts[0][2]] and len(told) == 3
    assert b"inputs sha256 " in (tmp_path / "sweep.png").read_bytes()


@pytest.mark.parametrize("text", ["0/2", "3/2", "1", "a/b", "1/2/3", "-1/2"])
def test_what_is_no_part_is_refused(text, capsys, tmp_path):
    with pytest.raises(SweepError, match="--part '.*': wanted I/N"):
        sweep.read_part(text)


@pytest.mark.usefixtures("undrawn")
def test_an_interrupted_sweep_keeps_its_table(tmp_path, monkeypatch):
    runs = make_runs(FOUR, [("seed", [0, 1, 2]), ("duration", [1.0])])

    def cut_short(*_):
        verdict = sweep.failed("as told")
        yield from ((row, verdict) for row in range(2))
        raise KeyboardInterrupt

    monkeypatch.setattr(sweep, "on_cores", cut_short)
    with pytest.raises(KeyboardInterrupt):
        run_sweep(runs, str(tmp_path))
    assert len(rows(str(tmp_path))) == 2


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    "told",
    ["", "[1, 2]", '{"ended": "complete"}', '{"ended": "complete", "checks": [3], "passed": 1}'],
)
def test_what_is_no_verdict_is_of_no_run_that_was_finished(tmp_path, told):
    runs = make_runs(FOUR, [("seed", [0]), ("duration", [0.2])])
    found = tmp_path / runs[0][0] / "verdict.json"
    found.parent.mkdir()
    found.write_text(told)
    (verdict,) = run_sweep(runs, str(tmp_path), jobs=1)
    assert verdict["ended"] == "complete" and verdict["duration"] == pytest.approx(0.2)
    assert found.read_text() != told


DIES = """
import os

from mrs_simulator import PioneerControl


class Dies(PioneerControl):
    def start(self):
        if len(self.numbers) == 3:
            os._exit(1)

    def pointMassLaw(self, hand):
        return 0.0 * hand
"""
TINY = [("seed", [0, 1]), ("duration", [1.0, 2.0])]


@pytest.fixture(scope="module")
def cluster():
    """The address of a Dask scheduler on this machine, with two worker processes."""
    dask = pytest.importorskip("dask")
    from dask.distributed import LocalCluster

    # Of each death the cluster blames all that waited on that worker.
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}), LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        dashboard_address=None,
        worker_dashboard_address=None,
        silence_logs="CRITICAL",
    ) as running:
        yield running.scheduler_address


def tidy(out):
    """Return the table without how fast this machine was."""
    return [{k: v for k, v in row.items() if k != "real_time_factor"} for row in rows(str(out))]


@pytest.mark.usefixtures("undrawn")
def test_a_cluster_gives_the_same_table_and_resumes(tmp_path, cluster, monkeypatch, capsys):
    runs = make_runs(FOUR, TINY)
    run_sweep(runs, str(tmp_path / "cores"), jobs=1)
    monkeypatch.chdir(tmp_path)  # the workers are elsewhere
    # Interrupted after one run.
    run_sweep(runs[:1], "cluster", scheduler=cluster)
    done = tmp_path / "cluster" / runs[0][0] / "run.csv"
    stamp = done.stat().st_mtime_ns
    arguments = [FOUR, "--out", "cluster", "--scheduler", cluster]
    axes = ["--sweep", "seed=0..1", "--sweep", "duration=1.0,2.0"]
    with pytest.raises(SystemExit):
        main(arguments + axes)
    assert "0 of 4 runs passed, 4 not judged" in capsys.readouterr().out
    assert done.stat().st_mtime_ns == stamp
    assert tidy(tmp_path / "cluster") == tidy(tmp_path / "cores") and len(tidy("cluster")) == 4
    for name, _, _ in runs:
        made = [
            (tmp_path / where / name / "run.csv").read_bytes() for where in ("cores", "cluster")
        ]
        assert made[0] == made[1]


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("where", ["cores", "cluster"])
def test_a_run_that_ends_its_process_fails_alone(tmp_path, where, request, monkeypatch):
    (tmp_path / "dies.py").write_text(DIES)
    monkeypatch.chdir(tmp_path)
    axes = [("robots", [2, 3, 4]), ("poses", [{"layout": "line"}]), ("duration", [1.0])]
    runs = make_runs(FOUR, axes, {"control.protocol": "dies.py:Dies"})
    scheduler = request.getfixturevalue("cluster") if where == "cluster" else ""
    verdicts = run_sweep(runs, "out", jobs=2, scheduler=scheduler)
    assert [verdict["ended"] == "complete" for verdict in verdicts] == [True, False, True]
    assert "died" in verdicts[1]["ended"]
    assert len(rows("out")) == 3


def dies_beside_another(place):
    wait_until((place / "beside").exists, 60.0)
    os._exit(1)


def is_killed_the_first_time(place):
    if not (place / "beside").exists():
        (place / "beside").touch()
        signal.pause()
    return "second"


def waits_for_another(place, own, other):
    (place / own).touch()
    wait_until((place / other).exists, 60.0)
    return own


def run_of(function, *arguments):
    return function(*arguments)


def test_after_a_run_that_ends_its_process_those_not_begun_run_beside_each_other(tmp_path):
    tasks = [
        (dies_beside_another, tmp_path),
        (is_killed_the_first_time, tmp_path),
        (waits_for_another, tmp_path, "a", "b"),
        (waits_for_another, tmp_path, "b", "a"),
    ]
    verdicts = dict(on_cores(run_of, tasks, 2))
    assert "died" in verdicts.pop(0)["ended"]
    assert verdicts == {1: "second", 2: "a", 3: "b"}


def test_processes_stay_from_batch_to_batch_and_are_made_anew_at_times(monkeypatch):
    cores = Cores(1)
    with contextlib.closing(cores):
        first, second = (dict(cores.run(run_of, [(os.getpid,)]))[0] for _ in range(2))
        assert first == second != os.getpid()
        assert failed("its process died") in dict(cores.run(run_of, [(os._exit, 1)])).values()
        third = dict(cores.run(run_of, [(os.getpid,)]))[0]
        monkeypatch.setattr(workers, "RENEWED", 1)
        assert len({first, third, dict(cores.run(run_of, [(os.getpid,)]))[0]}) == 3


def goes_on_after_an_interruption():
    os.kill(os.getpid(), signal.SIGINT)
    return "went on"


def interrupts_its_parent_and_waits(place):
    while not (place / "beside").exists():
        time.sleep(0.01)
    os.kill(os.getppid(), signal.SIGINT)
    signal.pause()


def waits(place):
    (place / "beside").touch()
    while True:
        signal.pause()


@pytest.mark.usefixtures("interruptible")
def test_an_interruption_is_heeded_by_the_one_that_waits_and_ends_the_others_at_once(tmp_path):
    before = set(multiprocessing.active_children())  # of other tests in this process
    assert dict(on_cores(run_of, [(goes_on_after_an_interruption,)], 1)) == {0: "went on"}
    tasks = [(waits, tmp_path), (interrupts_its_parent_and_waits, tmp_path)]
    with pytest.raises(KeyboardInterrupt):
        dict(on_cores(run_of, tasks, 2))
    assert set(multiprocessing.active_children()) <= before


def tells_its_number(place, own):
    (place / own).write_text(str(os.getpid()))


def tells_its_number_and_waits(place, own):
    tells_its_number(place, own)
    while True:
        signal.pause()


def has_ended(number):
    """Return whether the process ``number``, of another parent, runs no more."""
    try:
        with open("/proc/{}/stat".format(number)) as stat:
            return stat.read().rpartition(")")[2].split()[0] in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return True


def test_workers_whose_parent_is_killed_end_at_work_and_idle(tmp_path):
    places = [tmp_path / own for own in ("first", "second")]
    parent = multiprocessing.get_context("fork").Process(target=waits_for_workers, args=(tmp_path,))
    parent.start()
    wait_until(lambda: all(path.exists() and path.read_text() for path in places), 60.0)
    numbers = [int(path.read_text()) for path in places]
    assert not any(map(has_ended, numbers))
    parent.kill()
    parent.join()
    try:
        wait_until(lambda: all(map(has_ended, numbers)), 60.0)
    finally:
        for number in numbers:
            if not has_ended(number):
                os.kill(number, signal.SIGKILL)


def waits_for_workers(place):
    tasks = [(tells_its_number, place, "first"), (tells_its_number_and_waits, place, "second")]
    dict(on_cores(run_of, tasks, 2))


@pytest.mark.usefixtures("undrawn")
def test_an_interrupted_sweep_ends_soon_and_resumes(tmp_path):
    sweep = [sys.executable, "-m", "mrs_simulator.study.run.command", FOUR, "--out", str(tmp_path)]
    sweep += ["--sweep", "seed=0..199", "--duration", "5", "--jobs", "1"]
    process = subprocess.Popen(sweep, stderr=subprocess.PIPE)
    try:
        wait_until(lambda: (tmp_path / "sweep.csv").exists(), 60.0)
        process.terminate()
        assert b"interrupted; what has ended is in" in process.communicate(timeout=60.0)[1]
        assert process.returncode == 130
    finally:
        process.kill()
        process.wait()
    done = sorted(tmp_path.glob("*/verdict.json"))
    assert 0 < len(done) < 200
    before = [path.stat().st_mtime_ns for path in done]
    runs = make_runs(FOUR, [("seed", list(range(200)))], {"duration": 5.0})
    run_sweep([run for run in runs if (tmp_path / run[0]).exists()], str(tmp_path), jobs=1)
    assert [path.stat().st_mtime_ns for path in done] == before


DISPLACEMENT = os.path.join(ROOT, "scenarios", "displacement_formation.yaml")


def test_what_is_swept_holds_under_another_protocol_too():
    axes = [("control.parameters.gain", [0.1, 0.4])]
    given = {"control.protocol": "consensus", "duration": 3.0, "fidelity": "point_mass"}
    runs = make_runs(DISPLACEMENT, axes, given)
    scenarios = [scenario for _, _, scenario in runs]
    parameters = [scenario.control.parameters for scenario in scenarios]
    assert parameters == [{"l": 0.1, "gain": 0.1}, {"l": 0.1, "gain": 0.4}]
    assert {scenario.control.protocol for scenario in scenarios} == {"consensus"}
    assert {(s.duration, s.fidelity, s.title) for s in scenarios} == {
        (3.0, "point_mass", "6 robots, consensus")
    }
    # Another protocol, duration or seed is another run, in a directory of its own.
    others = [given, {}, dict(given, duration=4.0), dict(given, seed=1)]
    names = [name for other in others for name, _, _ in make_runs(DISPLACEMENT, axes, other)]
    assert len(set(names)) == 8


@pytest.mark.parametrize(
    "axis, given, said",
    [
        (("duration", [1.0]), {"duration": 2.0}, "duration = 2.0 is given and swept"),
        (("seed", [0]), {"robots": 3}, "topology with 3 robots: edge"),
        (("robots", ["3"]), {}, "robots: '3', wanted a whole number"),
        (("seed", [0]), {"control.protocol": "gone.py:Gone"}, "protocol file gone.py: not found"),
    ],
)
def test_what_cannot_be_given_to_a_sweep_is_refused(axis, given, said):
    with pytest.raises(ValueError, match=said):
        make_runs(DISPLACEMENT, [axis], given)


def test_a_mistake_that_all_runs_share_is_refused_before_the_first():
    with pytest.raises(SweepError, match=r"no run can begin: .*four.yaml: .*mean 'k'\?"):
        make_runs(FOUR, [("control.parameters.kk", [1, 2])])
    assert len(make_runs(FOUR, [(K, [-1, 0.02])])) == 2  # the other one can


def test_a_scheduler_that_is_not_there_is_named(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("mrs_simulator.study.run.workers.CONNECT_LIMIT", 0.5)
    with pytest.raises(SweepError, match="--scheduler tcp://127.0.0.1:9: .*"):
        run_sweep(make_runs(FOUR, TINY), str(tmp_path), scheduler="tcp://127.0.0.1:9")


@pytest.mark.parametrize(
    "words",
    [
        ["{}", "--out", "{}", "seed=0..1", "duration=1,2"],
        ["{}", "seed=0..1", "--out", "{}", "--vary", "duration=1,2"],
        ["--vary", "seed=0..1", "{}", "--vary=duration=1,2", "--out", "{}"],
    ],
)
def test_what_varies_is_an_argument_or_an_option(words, tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(command, "_sweep", lambda arguments: asked.append(arguments.sweep))
    paths = iter([FOUR, str(tmp_path)])
    with pytest.raises(SystemExit):
        sweep_main([next(paths) if word == "{}" else word for word in words])
    assert asked == [["seed=0..1", "duration=1,2"]]


def test_a_sweep_of_nothing_is_refused(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        sweep_main([FOUR, "--out", str(tmp_path)])
    assert ended.value.code == 2 and "nothing varies: wanted KEY=VALUES" in capsys.readouterr().err


@pytest.mark.usefixtures("undrawn")
def test_what_runs_report_is_written_once_with_how_many_they_are(tmp_path, capfd):
    given = {"fidelity": "kinematic", "duration": 5.0}
    rates = ("control.rate", [10.0, 20.0])
    runs = make_runs(scenario_path("consensus"), [("seed", [0, 1]), rates], given)
    run_sweep(runs, str(tmp_path), jobs=2)
    said = capfd.readouterr().err
    assert said.count("theory leads the points of") == 1
    assert said.rstrip().endswith("(4 of 4 runs)")


def test_the_command(tmp_path, capsys, monkeypatch):
    arguments = [FOUR, "--out", str(tmp_path), "--sweep", "seed=0..1", "--sweep", "duration=1"]
    with pytest.raises(SystemExit) as ended:
        main(arguments + ["--jobs", "2"])
    assert ended.value.code == 0  # as far as theory has come by then
    said = capsys.readouterr().out
    assert "0 of 2 runs passed, 2 not judged\n" in said and "figure: " in said
    monkeypatch.setattr("mrs_simulator.study.draw.sweep_figures.sweep_figure", lambda *_: None)
    with pytest.raises(SystemExit):
        main([*arguments[:-2], "--duration", "2", "--protocol", "consensus"])
    assert len(list(tmp_path.glob("*/verdict.json"))) == 4
    for path in tmp_path.glob("*/verdict.json"):
        verdict = json.loads(path.read_text())
        wanted = {"formation": 1.0, "consensus": 2.0}[verdict["protocol"]]
        assert verdict["duration"] == pytest.approx(wanted)
    with pytest.raises(SystemExit) as ended:
        main(arguments + ["--sweep", "seed=3"])
    assert ended.value.code == 2 and "swept twice" in capsys.readouterr().err


def test_the_command_says_why_runs_failed_and_no_figure_where_there_is_none(tmp_path, capfd):
    (tmp_path / "law.py").write_text(
        "from mrs_simulator import PioneerControl\n"
        "class Wrong(PioneerControl):\n"
        "    def calculateControlLaw(self, pos_map):\n"
        "        raise RuntimeError('never')\n"
    )
    (tmp_path / "sweep.png").write_text("of an earlier sweep")
    given = [FOUR, "--out", str(tmp_path), "--protocol", str(tmp_path / "law.py") + ":Wrong"]
    with pytest.raises(SystemExit) as ended:
        main(given + ["--sweep", "fidelity=kinematic,point_mass", "--jobs", "1"])
    assert ended.value.code == 1
    said, told = capfd.readouterr()
    assert told.count("Traceback") == 1 and "RuntimeError: never (2 of 2 runs)\n" in told
    assert "0 of 2 runs passed\n" in said
    assert "  2 x at 0.000 s the law failed: RuntimeError: never" in said
    assert "table: " in said and "figure" not in said


@pytest.mark.usefixtures("undrawn")
def test_requirements_are_columns_and_reasons(tmp_path):
    content = load_scenario(FOUR).to_dict()
    content["requirements"] = {"apart": "always distance > 1 m", "slow": "always speed < 1 mm/s"}
    path = tmp_path / "four.yaml"
    path.write_text(yaml.safe_dump(content))
    runs = make_runs(str(path), [("duration", [0.5, 1.0])])
    verdicts = run_sweep(runs, str(tmp_path / "out"), jobs=1)
    with open(str(tmp_path / "out" / "sweep.csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    assert all(float(row["robustness of apart"]) > 0.0 for row in rows)
    assert all(float(row["robustness of slow"]) < 0.0 for row in rows)
    lines = summary(verdicts)
    assert "  2 x requirement slow" in lines and not any("confidence" in line for line in lines)
    # Clopper and Pearson: none of 2, the upper end is 1 - 0.025^(1/2).
    assert (
        summary(verdicts, drawn=True)[1] == "  95 % confidence interval of the share: 0 % to 84.2 %"
    )
