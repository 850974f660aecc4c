"""The pages of the documentation, in a clone or in an installed package: ``mrs-simulator docs``."""

import argparse
import difflib
import os
import re
import sys

from mrs_simulator.core.program import program
from mrs_simulator.core.writing import printing

PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
OF_CLONE = os.path.join(os.path.dirname(os.path.dirname(PACKAGE)), "docs")
INSTALLED = os.path.join(PACKAGE, "docs")
FENCE = "```"
HEADING = re.compile(r"(#+) (.+)")
BAD_INPUT = 2  # exit code


class PageError(ValueError):
    """No such page, or no such heading on it; the message names the nearest."""


def folder():
    """Return the directory of the pages."""
    return INSTALLED if os.path.isdir(INSTALLED) else OF_CLONE


def reference(link, installed=None):
    """Return how a user finds ``link``, such as ``docs/scenarios.md#graphs``.

    In a clone that is the file; of an installed package it is the command that prints it.
    """
    installed = os.path.isdir(INSTALLED) if installed is None else installed
    return "mrs-simulator docs " + _bare(link) if installed else link


def _bare(link):
    return link[len("docs/") :] if link.startswith("docs/") else link


def pages():
    """Return the names of all pages, such as ``verdict`` and ``protocols/consensus``."""
    found = []
    for directory, _, names in os.walk(folder()):
        near = os.path.relpath(directory, folder()).replace(os.sep, "/")
        prefix = "" if near == "." else near + "/"
        found += [prefix + name[: -len(".md")] for name in names if name.endswith(".md")]
    return sorted(found)


def text_of(link):
    """Return the text of the page that ``link`` names, or of its section, where it has a ``#heading``.

    Raises ``PageError``.
    """
    name, _, anchor = _bare(link).partition("#")
    name = name[: -len(".md")] if name.endswith(".md") else name
    known = pages()
    name = "protocols/" + name if name not in known and "protocols/" + name in known else name
    if name not in known:
        raise PageError("page {!r}: {}".format(name, _nearest(name, known)))
    with open(os.path.join(folder(), name + ".md"), encoding="utf-8") as file:
        text = file.read()
    return _section(text, anchor) if anchor else text


def _section(text, anchor):
    """Return the section of ``text`` with the ``anchor``, up to the next heading that is no part of it."""
    lines, level, kept, known, fenced = text.split("\n"), 0, [], [], False
    for line in lines:
        fenced ^= line.startswith(FENCE)
        heading = None if fenced else HEADING.fullmatch(line)
        if heading:
            known.append(_anchor(heading.group(2)))
            depth = len(heading.group(1))
            if level and depth <= level:
                break
            level = level or (depth if known[-1] == anchor else 0)
        if level:
            kept.append(line)
    if not kept:
        raise PageError("heading {!r}: {}".format(anchor, _nearest(anchor, known)))
    return "\n".join(kept).rstrip() + "\n"


def _anchor(heading):
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def _nearest(name, known):
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.4)
    hint = "did you mean {!r}?".format(near[0]) if near else "wanted one of " + ", ".join(known)
    return "there is none; " + hint


@printing
def main(argv=None):
    """Run the command ``docs``: print a page, a section of it, or the list of pages."""
    parser = argparse.ArgumentParser(
        prog=program("docs"), description="Print a page of the documentation, or a section of it."
    )
    parser.add_argument(
        "page", nargs="?", help="such as scenarios.md#graphs, as errors name it; default: a list"
    )
    wanted = parser.parse_args(argv).page
    if wanted is None:
        print("\n".join(pages()))
        return
    try:
        print(text_of(wanted), end="")
    except PageError as error:
        print("docs: {}".format(error), file=sys.stderr)
        sys.exit(BAD_INPUT)
