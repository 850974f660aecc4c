#!/usr/bin/env python3
"""How far each protocol's theorem carries to robots with ramps: python3 docs/make_ramps.py [NAME ...]

Each protocol's scenario runs on its robots, Pioneers unless it says others, with their factory settings,
and is asked for the requirements in docs/ramps.yaml: ``margins`` along ``ALONG``, and ``break`` from starts
near the scenario's.  What is found goes to docs/ramps.json with its conditions, a protocol at a time;
``python3 docs/make_protocols.py --text`` then writes it on the pages.  Needs the Python package cma.
"""

import argparse
import json
import math
import operator
import os
import time

import yaml

from mrs_simulator.core.writing import write_text
from mrs_simulator.scenario.scenario import load_scenario, scenario_of_file
from mrs_simulator.scenario.search import search_from
from mrs_simulator.scenario.shipped import shipped_scenarios
from mrs_simulator.study.run.sweep import put_key
from mrs_simulator.study.search.breaking import Search
from mrs_simulator.study.search.margins import RATE, Margins, axes_of
from mrs_simulator.study.search.space import Space
from mrs_simulator.verdict.requirements.results import line_of

DOCS = os.path.dirname(os.path.abspath(__file__))
ASKED, FOUND = os.path.join(DOCS, "ramps.yaml"), os.path.join(DOCS, "ramps.json")
OTHER_NAMES = {"formation": "paper_four"}  # protocols whose scenario is not called like them
DELAY, LOSS = "mismatch.delay", "links.loss"
ALONG = ((DELAY, 1.0), (RATE, 1.0), (LOSS, 0.9))
RUNS, SEED = 30, 1  # of ``break``
NEAR = 0.5  # [m] along x and y, and [rad]: how far searched starts are from the scenario's at most
WORDS = {  # how a value on an axis is said
    DELAY: "up to a delay of {} s",
    RATE: "down to {} commands per second",
    LOSS: "up to a share of {} of the messages lost",
}
NO_DELAY = "without a delay alone"  # where the first step of one breaks


# What is asked ------------------------------------------------------------------------------------


def asked():
    """Return by protocol what docs/ramps.yaml asks: ``requirements``, and what is ``changed``."""
    with open(ASKED, encoding="utf-8") as file:
        return yaml.safe_load(file)


def conditions(name):
    """Return under which conditions the protocol ``name`` is measured, a plain mapping."""
    own = asked()[name]
    return {
        "scenario": OTHER_NAMES.get(name, name) + ".yaml",
        "changed": own.get("changed", {}),
        "requirements": own["requirements"],
        "along": dict(ALONG),
        "runs": RUNS,
        "seed": SEED,
        "near": own.get("near", NEAR),
    }


def content_of(given):
    """Return ``(content, path)`` of the scenario that the conditions ``given`` mean."""
    scenario = load_scenario(os.path.join(shipped_scenarios(), given["scenario"]))
    content = scenario.to_dict()
    content["control"].pop("saturation", None)
    content.update(fidelity="kinematic", limits="firmware", requirements=given["requirements"])
    for key, value in given["changed"].items():
        put_key(content, key, value)
    return content, scenario.path


def starts(poses, near):
    """Return the ``Search`` of the starts near ``poses`` (n, 3)."""
    ranges = {
        "poses[{}][{}]".format(row, axis): [float(value - near), float(value + near)]
        for row, pose in enumerate(poses)
        for axis, value in enumerate(pose)
    }
    return search_from(ranges, "starts")


# What is found ------------------------------------------------------------------------------------


def measured(name, jobs=None):
    """Return what is found of the protocol ``name``, with its conditions, a plain mapping."""
    given = conditions(name)
    content, path = content_of(given)
    scenario = scenario_of_file(content, path)
    search = Search(content, path, None, jobs)
    found = Margins(search, axes_of(scenario, content, ALONG), scenario.n).found(together=False)
    space = Space(starts(scenario.poses, given["near"]), scenario.n)
    near = Search(content, path, space, jobs)
    near.nominal()
    broken = near.find(RUNS, SEED, "cma")
    return {
        **given,
        "robots": sorted(set(scenario.kinds)),
        "axes": found["axes"],
        "dead": found["dead"],
        "tried": search.runs,
        "broken": broken
        and {
            "runs": broken.runs,
            "poses": starts_of(broken.variation, scenario.n),
            "text": line_of(broken.trial.worst),
        },
    }


def starts_of(variation, robots):
    """Return the poses [x, y, theta] of so many ``robots`` in a ``variation`` of :func:`starts`."""
    return [
        [variation["poses[{}][{}]".format(row, axis)] for axis in range(3)] for row in range(robots)
    ]


def results():
    """Return what docs/ramps.json holds, by protocol."""
    if not os.path.exists(FOUND):
        return {}
    with open(FOUND, encoding="utf-8") as file:
        return json.load(file)


# What is told -------------------------------------------------------------------------------------


def section(name):
    """Return the section of the protocol's page on robots with ramps, "" where none was measured."""
    found = results().get(name)
    if found is None:
        return ""
    text = "`{}` on {} with factory settings, ramps and all (`limits: firmware`), with {}, is asked for"
    length = load_scenario(os.path.join(shipped_scenarios(), found["scenario"])).hand_length
    changed = {"control.parameters.l": length, **found["changed"]}
    told = ", ".join("`{}: {:g}`".format(*pair) for pair in changed.items())
    kinds = " and ".join(map("`{}`".format, found["robots"]))
    asked_for = ["- `{}: {}`".format(*pair) for pair in found["requirements"].items()]
    return "\n\n".join(
        [
            "## On robots with ramps",
            text.format(found["scenario"], kinds, told),
            "\n".join(asked_for),
            " ".join([*margins_told(found["axes"]), dead_told(found["dead"])]),
            broken_told(found),
            "Each axis alone, outwards from the scenario's value, delays in whole steps of the world: "
            "[margins](../search.md#margins). All numbers and conditions: [ramps.json](../ramps.json).",
        ]
    )


def margins_told(axes):
    """Return in sentences up to where on the ``axes`` all holds, and where nothing breaks.

    Of those alone that act on the protocol.
    """
    limits, held = [], []
    for axis in filter(operator.itemgetter("acts"), axes):
        pairs = {name: pair for name, pair in axis["breaks"].items() if pair}
        words = WORDS[axis["key"]]
        if pairs:
            first = min(pairs, key=lambda name: abs(pairs[name][1] - axis["nominal"]))
            holds, breaks = shown(*pairs[first])
            holds = NO_DELAY if axis["key"] == DELAY and holds == "0" else words.format(holds)
            limits.append("{} (`{}` breaks at {})".format(holds, first, breaks))
        elif axis["tried"]:
            held.append(words.format("{:g}".format(axis["end"])))
    told = ["Holds {}.".format(", ".join(limits))] if limits else []
    return told + (["Not broken {}.".format(", ".join(held))] if held else [])


def shown(holds, breaks):
    """Return both numbers with two digits: what holds rounded to its own side, and so what breaks."""
    scale = 10.0 ** (1 - math.floor(math.log10(max(abs(holds), abs(breaks)))))
    ways = (math.floor, math.ceil) if breaks > holds else (math.ceil, math.floor)
    values = [way(value * scale) / scale for way, value in zip(ways, (holds, breaks))]
    return tuple(map("{:g}".format, values))


def dead_told(dead):
    """Return in a sentence without which robots, which then never move, something breaks."""
    if all(broken is None for broken in dead.values()):
        return "Robots that never move are refused."
    missed = [number for number, broken in dead.items() if broken]
    if not missed:
        return "Any one robot may be dead, that is, never move."
    if len(missed) == len(dead):
        return "It breaks with any one robot dead, that is, never moving."
    return "It breaks with robot {} dead, that is, never moving.".format(" or ".join(missed))


def broken_told(found):
    """Return in a sentence what ``break`` found from starts near the scenario's."""
    text = "From starts at most {near:g} m along x and y and {near:g} rad from the scenario's, `break` "
    text = (text + "with seed {seed} finds ").format(**found)
    broken = found["broken"]
    if broken is None:
        return text + "in {} runs none that breaks it, which is no proof.".format(found["runs"])
    return text + "one that breaks it, after {} runs: {}.".format(broken["runs"], broken["text"])


def main():
    """Measure the protocols that the command line names, or all, and write what is found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "names", nargs="*", metavar="protocol", help="in this order, by default all"
    )
    parser.add_argument("--jobs", type=int, metavar="N", help="processes")
    arguments = parser.parse_args()
    for name in arguments.names or asked():
        began = time.monotonic()
        found = {**results(), name: measured(name, arguments.jobs)}
        write_text(FOUND, json.dumps(found, indent=1, sort_keys=True) + "\n")
        print("{:28}{:.0f} s".format(name, time.monotonic() - began), flush=True)


if __name__ == "__main__":
    main()
