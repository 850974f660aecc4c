#!/usr/bin/env python3
"""Make the page of each shipped protocol: python3 docs/make_protocols.py [--text] [NAME ...]

Its picture and its verdict come from a run of its scenario, its limits on robots with ramps from what
make_ramps.py found, all else from its docstring and its declared parameters: docs/protocols/NAME.md, and in
docs/images/protocols NAME.png, and NAME.svg, which moves.  With --text nothing is run: verdicts and
pictures stay.
"""

import functools
import io
import os
import re
import sys

import make_ramps
from make_references import references

from mrs_simulator import simulate
from mrs_simulator.core.writing import write_bytes, write_text
from mrs_simulator.protocols import HOMES, shipped
from mrs_simulator.scenario.scenario import load_scenario
from mrs_simulator.scenario.shipped import shipped_scenarios

DOCS = os.path.dirname(os.path.abspath(__file__))
OTHER_NAMES = {"formation": "paper"}  # protocols whose scenario is not called like them
BESIDE = {"trajectory": "Mellinger2011", "line_of_sight": "Borhaug2008"}  # not in the docstring
WIDTH, RESOLUTION, COLOURS = 5.0, 110, 64  # [in], [px/in], [-] of the picture
VERDICT = re.compile(r"^ends with\n\n```text\n(.*?)\n```$", re.M | re.S)
OF_THE_MACHINE = "  achieved real-time factor"  # the verdict's line that is another one at each run


def main():
    """Make the pages of the protocols that the command line names, or of all."""
    for folder in (page_path(""), picture_path("")):
        os.makedirs(os.path.dirname(folder), exist_ok=True)
    text_alone = "--text" in sys.argv
    for name in [word for word in sys.argv[1:] if word != "--text"] or sorted(HOMES):
        if text_alone:
            write(name, verdict_on(name))
            continue
        run = simulate(scenario_name(name) + ".yaml")
        figure = run.trajectories(width=WIDTH, style={"font.size": 8.0})
        write_picture(name, figure)
        run.animate(width=WIDTH).save(picture_path(name, ".svg"))
        told = [line for line in str(run).splitlines() if not line.startswith(OF_THE_MACHINE)]
        write(name, "\n".join(told))
        print("{:28}{}".format(name, told[0]), flush=True)


def write(name, verdict):
    """Write the protocol's page with the text of its ``verdict``, whole or not at all."""
    write_text(page_path(name), page(name, verdict))


def verdict_on(name):
    """Return the text of the verdict that the protocol's page has now."""
    with open(page_path(name), encoding="utf-8") as file:
        return VERDICT.search(file.read()).group(1)


def scenario_name(name):
    """Return the name of the scenario that shows the protocol."""
    return OTHER_NAMES.get(name, name)


def page_path(name):
    """Return the path of the protocol's page."""
    return os.path.join(DOCS, "protocols", name + ".md")


def picture_path(name, ending=".png"):
    """Return the path of the protocol's picture; the one with the ``ending`` ``.svg`` moves."""
    return os.path.join(DOCS, "images", "protocols", name + ending)


def write_picture(name, figure):
    """Write the protocol's picture, ``figure`` with ``COLOURS`` colours, whole or not at all."""
    from PIL import Image  # comes with matplotlib

    drawn, small = io.BytesIO(), io.BytesIO()
    figure.savefig(drawn, format="png", dpi=RESOLUTION)
    with Image.open(drawn) as picture:
        reduced = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    reduced.save(small, format="png", optimize=True)
    write_bytes(picture_path(name), small.getvalue())


def page(name, verdict):
    """Return the text of the page, with the text of its ``verdict``."""
    law, scenario = shipped(name), scenario_name(name) + ".yaml"
    first, *more = paragraphs(law)
    theorem = [part for part in more if part.startswith("Theorem: ")]
    remarks = [part for part in more if part not in theorem]
    title = scenarios_of(name)[scenario]
    parts = [
        "# `{}`".format(name),
        first,
        *remarks,
        "![{}](../images/protocols/{}.svg)".format(title, name),
        "*{}*, in eight seconds.".format(title),
        "## What theory says",
        stated(theorem),
        "## Parameters",
        parameters(law),
        "## Its verdict",
        "```sh\nmrs-simulator experiment {} --out {}\n```".format(scenario, name),
        "ends with",
        "```text\n{}\n```".format(verdict),
        "![Paths](../images/protocols/{}.png)".format(name),
        "Green: the robots' paths; black: those of theory, where it predicts them.",
        make_ramps.section(name),
        "What each line says: [a verdict, line by line](../verdict.md). How to write a law of your own: "
        "[protocols](../protocols.md).",
        others(name),
        cited("\n".join(paragraphs(law)), BESIDE.get(name)),
        "Law: `{}`.".format(law.__module__.replace(".", "/") + ".py"),
    ]
    return "\n\n".join(filter(None, parts)) + "\n"


def cited(text, key):
    """Return the references that ``text`` names, and that with the ``key``, a section; "" without any."""
    rows = ["- " + each.text for each in references() if each.key == key or each.is_cited_in(text)]
    return "## References\n\n" + "\n".join(rows) if rows else ""


def paragraphs(law):
    """Return the paragraphs of the docstring of ``law``, each as one line of Markdown."""
    found = re.split(r"\n\s*\n", law.__doc__.strip())
    return [" ".join(part.split()).replace("``", "`") for part in found]


def stated(theorem):
    """Return the theorem's paragraph as a sentence of its own."""
    text = theorem[0].partition(": ")[2]
    return text[0].upper() + text[1:]


def parameters(law):
    """Return the table of the law's parameters."""
    rows = ["| name | default | wanted | meaning |", "|---|---|---|---|"]
    for each in law.PARAMETERS:
        unit = " " + each.unit if each.unit else ""
        wanted = each._replace(why="").wanted()
        default = "`{}{}`".format(each.default, unit)
        rows.append("| `{}` | {} | {} | {} |".format(each.name, default, wanted, each.meaning))
    return "\n".join(rows)


def scenarios_of(name):
    """Return the titles of the shipped scenarios that run the protocol, by name."""
    return {file: title for file, protocol, title in shipped_runs() if protocol == name}


def overview():
    """Return the table of all protocols: name, law, and the first sentence of the theorem."""
    rows = ["| name | law | what theory says |", "|---|---|---|"]
    for name in HOMES:
        first, *more = paragraphs(shipped(name))
        theorem = stated([part for part in more if part.startswith("Theorem: ")])
        cells = first, theorem.partition(". ")[0].rstrip(".") + "."
        law, says = (cell.replace("|", "\\|") for cell in cells)
        rows.append("| [`{0}`](protocols/{0}.md) | {1} | {2} |".format(name, law, says))
    return "\n".join(rows)


def pictures(across=3):
    """Return a table with the picture of every protocol, ``across`` in a row."""
    cells = [
        "[![{0}](images/protocols/{0}.png)](protocols/{0}.md) [`{0}`](protocols/{0}.md)".format(
            each
        )
        for each in sorted(HOMES)
    ]
    rows = [cells[at : at + across] for at in range(0, len(cells), across)]
    head = "| " + " | ".join([" "] * across) + " |\n" + "|---" * across + "|"
    return "\n".join([head, *("| " + " | ".join(row) + " |" for row in rows)])


@functools.lru_cache(maxsize=None)
def shipped_runs():
    """Return ``(name, protocol, title)`` of each shipped scenario."""
    files = sorted(file for file in os.listdir(shipped_scenarios()) if file.endswith(".yaml"))
    scenarios = [load_scenario(os.path.join(shipped_scenarios(), file)) for file in files]
    return [(file, each.control.protocol, each.title) for file, each in zip(files, scenarios)]


def others(name):
    """Return a list of the protocol's further scenarios, "" without any."""
    more = {
        key: title
        for key, title in scenarios_of(name).items()
        if key != scenario_name(name) + ".yaml"
    }
    rows = ["- `{}`: {}".format(file, title) for file, title in more.items()]
    return "More scenarios with it:\n\n" + "\n".join(rows) if rows else ""


if __name__ == "__main__":
    main()
