"""Values of every shipped scenario, recorded so that a change of the code cannot change them unseen.

The tests run the first seconds of each, as ``FIRST`` has them; ``python3 test/recorded_values.py
--compare`` runs them whole, which takes minutes.  Without an option the program adds scenarios that are new
to ``test/data/recorded_values.json``, on the kind of machine that the others were recorded on, and leaves
those untouched.  ``--anew`` runs and writes all, ``--anew NAME ...`` the scenarios of these names: to be
done only where numbers had to change, in a commit that says why.
"""

import base64
import ctypes
import functools
import hashlib
import json
import os
import platform
import sys
import zlib

import numpy as np

from mrs_simulator.record.recording import Recorder
from mrs_simulator.scenario.scenario import FIDELITIES, load_scenario
from mrs_simulator.state.layout import basic_layout
from mrs_simulator.study.run.experiment import Experiment, LawFailed

HERE = os.path.dirname(os.path.abspath(__file__))
SCENARIOS = os.path.join(os.path.dirname(HERE), "scenarios")
RECORDED = os.path.join(HERE, "data", "recorded_values.json")
# [s] of each run that the tests compare; a second of bodies with forces takes as long as ten of others.
FIRST = {"kinematic": 5.0, "dynamic": 2.0, "point_mass": 5.0}
ELSEWHERE = 10.0  # [s] of a run at another fidelity than the scenario's own
KEPT = (0.0, 0.02, 0.1, 0.5, 1.0)  # [-] where in a run its values are kept beside their hashes
SMALL = 1e-9  # [-] agreement on another machine, relative above 1
NUDGE = 1e-13  # [m, rad] of the initial poses: what another machine's last bits amount to
TAME = 1e-10  # [-] a sample that a nudge moves further than this is not compared on other machines


def machine():
    """Return what decides the last bits of a float64 on this machine, as one line."""
    features = np.core._multiarray_umath.__cpu_features__
    present = "+".join(sorted(name for name, there in features.items() if there))
    digest = hashlib.sha256(present.encode()).hexdigest()[:12]
    libc = "-".join(platform.libc_ver())
    return "numpy {}, {}, cpu {}, {}".format(np.__version__, _blas_kernel(), digest, libc)


def _blas_kernel():
    """Return the kernel that OpenBLAS chose for this processor, or the BLAS library's name."""
    with open("/proc/self/maps", encoding="utf-8") as file:
        loaded = {line.split()[-1] for line in file if "blas" in line.lower()}
    for path in sorted(path for path in loaded if path.startswith("/")):
        for name in ("openblas_get_corename", "openblas_get_corename64_"):
            kernel = getattr(ctypes.CDLL(path), name, None)
            if kernel is not None:
                kernel.restype = ctypes.c_char_p
                return "OpenBLAS " + kernel().decode()
    return "+".join(sorted(map(os.path.basename, loaded))) or "no BLAS"


def cases():
    """Return ``(scenario, fidelity)`` of all recorded runs."""
    names = sorted(name[:-5] for name in os.listdir(SCENARIOS) if name.endswith(".yaml"))
    return [(name, fidelity) for name in names for fidelity in FIDELITIES]


@functools.lru_cache(maxsize=None)
def _shipped(name):
    return load_scenario(os.path.join(SCENARIOS, name + ".yaml"))


def run_values(name, fidelity, directory, nudge=0.0, longest=np.inf):
    """Return the columns of ``run.csv``, name to (m, n), or the text that refused the run.

    ``nudge`` is added to all initial poses; ``longest`` [s]: what the run lasts at most.
    """
    scenario = _shipped(name)
    if fidelity != scenario.fidelity:
        duration = min(scenario.duration, ELSEWHERE)
        scenario = scenario._replace(fidelity=fidelity, duration=duration)
    scenario = scenario._replace(duration=min(scenario.duration, longest))
    if nudge:
        scenario = scenario._replace(poses=scenario.poses + nudge)
    path = os.path.join(str(directory), "run.csv")
    try:
        experiment = Experiment(scenario)
    except ValueError as error:
        return "refused: " + str(error).replace(SCENARIOS, "")
    layout = basic_layout(experiment.control.team.axes)
    numbers = range(1, scenario.n + 1)
    with Recorder(path, numbers, scenario.hand_length, layout=layout) as recorder:
        try:
            for stamp, pose, command in experiment.samples():
                recorder.sample(stamp, experiment.state(pose, command))
        except LawFailed as error:
            return "failed: {}".format(error)
        finally:
            experiment.world.close()
    with open(path, encoding="ascii") as file:
        header = file.readline().strip().split(",")
        table = np.array([line.split(",") for line in file], dtype=float)
    table = table.reshape(-1, scenario.n, len(header))
    return {column: table[:, :, index] for index, column in enumerate(header)}


def first(values, fidelity):
    """Return ``values`` up to ``FIRST``."""
    rows = int(np.searchsorted(values["time"][:, 0], FIRST[fidelity] + 1e-6))
    return {column: numbers[:rows] for column, numbers in values.items()}


def digests(values):
    """Return the hash of each column of ``values``, 16 hexadecimal digits by name."""
    return {
        column: hashlib.sha256(np.ascontiguousarray(numbers).tobytes()).hexdigest()[:16]
        for column, numbers in values.items()
    }


def kept(values):
    """Return samples of ``values`` at the shares ``KEPT`` of the run, (5, n, columns)."""
    rows = [int(share * (len(values["time"]) - 1)) for share in KEPT]
    return np.stack([column[rows] for column in values.values()], axis=-1)


def differing(came, wanted, tolerance):
    """Return which values differ by more than ``tolerance``, relative above 1."""
    return np.abs(came - wanted) > tolerance * np.maximum(1.0, np.abs(wanted))


def tame(values, nudged):
    """Return how many of the kept samples, from the first, a nudge leaves where they are."""
    wild = differing(kept(nudged), kept(values), TAME).any(axis=(1, 2))
    return int(np.argmax(wild)) if wild.any() else len(wild)


def packed(array):
    """Return ``array`` as text for JSON, to the bit; ``unpacked`` undoes it."""
    text = base64.b64encode(zlib.compress(array.astype("<f8").tobytes(), 9)).decode()
    return {"shape": list(array.shape), "values": text}


def unpacked(stored):
    """Return the array in ``stored``."""
    numbers = np.frombuffer(zlib.decompress(base64.b64decode(stored["values"])), "<f8")
    return numbers.reshape(stored["shape"])


def facts(values, nudged):
    """Return what is recorded of ``values``; ``nudged``: those of the run whose start was nudged."""
    return {"digests": digests(values), "kept": packed(kept(values)[: tame(values, nudged)])}


def changes(values, recorded, same_machine):
    """Return the columns of ``values`` that are not those ``recorded``, as :func:`facts` has them."""
    if same_machine:
        return {
            name for name, digest in digests(values).items() if digest != recorded["digests"][name]
        }
    wanted = unpacked(recorded["kept"])
    far = differing(kept(values)[: len(wanted)], wanted, SMALL)
    names = list(values)
    return {names[column] for column in np.nonzero(far)[2]}


def compare(directory):
    """Run every case whole and print those whose values are not the recorded ones; return how many."""
    known, wrong = load(), 0
    for case, recorded in known["runs"].items():
        values = run_values(*case.split(), directory)
        if "outcome" in recorded:
            changed = set() if values == recorded["outcome"] else {"outcome"}
        else:
            changed = changes(values, recorded["whole"], machine() == known["machine"])
        wrong += bool(changed)
        print(
            case,
            "other values: {}".format(", ".join(sorted(changed))) if changed else "same",
            flush=True,
        )
    return wrong


def record(directory, known=None):
    """Run every case and return what ``RECORDED`` holds of them on this machine.

    ``known``: what it holds already, which stays; only for cases of which it knows nothing.
    """
    known = known or {"machine": machine(), "runs": {}}
    if known["machine"] != machine():
        text = "recorded on {}, and this is {}: wanted the same, or --anew for all"
        raise SystemExit(text.format(known["machine"], machine()))
    runs = dict(known["runs"])
    for name, fidelity in cases():
        case = "{} {}".format(name, fidelity)
        if case in runs:
            continue
        values = run_values(name, fidelity, directory)
        if isinstance(values, str):
            runs[case] = {"outcome": values}
        else:
            nudged = run_values(name, fidelity, directory, NUDGE)
            begun = (first(each, fidelity) for each in (values, nudged))
            runs[case] = {"whole": facts(values, nudged), **facts(*begun)}
        print(case, flush=True)
    return {"machine": machine(), "runs": runs}


def load():
    """Return what ``RECORDED`` holds."""
    with open(RECORDED, encoding="utf-8") as file:
        return json.load(file)


if __name__ == "__main__":
    import tempfile

    if sys.argv[1:] == ["--compare"]:
        with tempfile.TemporaryDirectory() as directory:
            sys.exit(1 if compare(directory) else 0)
    given = [argument for argument in sys.argv[1:] if argument != "--anew"]
    paths = [argument for argument in given if argument.endswith(".json")]
    names = set(given) - set(paths)
    known = load() if names or "--anew" not in sys.argv[1:] else None
    if names - {name for name, _ in cases()}:
        raise SystemExit("scenarios {}: not among those shipped".format(", ".join(sorted(names))))
    for case in [case for case in (known or {"runs": ()})["runs"] if case.split()[0] in names]:
        del known["runs"][case]
    with tempfile.TemporaryDirectory() as directory:
        content = record(directory, known)
    with open(paths[0] if paths else RECORDED, "w", encoding="utf-8") as file:
        json.dump(content, file, indent=1, sort_keys=True)
        file.write("\n")
