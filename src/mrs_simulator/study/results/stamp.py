"""What went into a run, as one hash: equal runs have the same, wherever their files lie."""

import hashlib
import os

from mrs_simulator.protocols.loading import from_anywhere
from mrs_simulator.scenario.surroundings.maps import files_of_map
from mrs_simulator.study.run.run_keys import law_files
from mrs_simulator.vehicles.registry import files_of_kinds

CHUNK = 1 << 20  # [bytes] of a file in memory
STAMP = "inputs sha256 {}"


def input_files(scenario):
    """Return the paths of the files that a run of ``scenario`` reads: law, its imports, kinds, map."""
    files = law_files(scenario.control.protocol, scenario.path)
    files += files_of_kinds(scenario)[0] + (files_of_map(scenario) if scenario.map else [])
    return sorted(set(files))


def digest(path):
    """Return the SHA-256 of the file at ``path``, "" where there is none."""
    content = hashlib.sha256()
    try:
        with open(path, "rb") as file:
            for part in iter(lambda: file.read(CHUNK), b""):
                content.update(part)
    except OSError:
        return ""
    return content.hexdigest()


_newest = [(None, "")]  # a scenario and its text: YAML takes some ms to write


def portable_yaml(scenario):
    """Return ``scenario`` as YAML text that means the same from anywhere."""
    known, text = _newest[0]
    if known is not scenario:
        text = from_anywhere(scenario).to_yaml()
        _newest[0] = scenario, text
    return text


def stamp_of(scenario):
    """Return the hash of ``scenario`` and its :func:`input_files` as figures carry it, "" without one.

    Of paths the last part counts, so that a copy of the files elsewhere has the same.
    """
    if scenario is None:
        return ""
    files, text = input_files(scenario), portable_yaml(scenario)
    for path in files:
        text = text.replace(path, os.path.basename(path))
    whole = [hashlib.sha256(text.encode("utf-8")).hexdigest(), *sorted(map(digest, files))]
    return STAMP.format(hashlib.sha256(" ".join(whole).encode("ascii")).hexdigest())


def stamp_of_all(scenarios):
    """Return the hash of the inputs of several runs, in their order, as figures of sweeps carry it."""
    whole = " ".join(map(stamp_of, scenarios))
    return STAMP.format(hashlib.sha256(whole.encode("ascii")).hexdigest())
