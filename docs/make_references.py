#!/usr/bin/env python3
"""Make docs/references.md from paper/paper.bib: python3 docs/make_references.py

A test compares both; ``make_protocols.py`` takes the references of each protocol's page from here.
"""

import os
import re
import unicodedata
from typing import NamedTuple, Tuple

from mrs_simulator.core.writing import write_text

DOCS = os.path.dirname(os.path.abspath(__file__))
BIBLIOGRAPHY = os.path.join(os.path.dirname(DOCS), "paper", "paper.bib")
FIELD = re.compile(r"(\w+) = \{((?:[^{}]|\{[^{}]*\})*)\}")
HEAD = """# References and how to cite

## How to cite

To cite this package: `CITATION.cff` in the repository, or as a software entry for BibTeX on its first
page. Name the version, and the seed and `provenance.json` of your runs: whoever has both
[gets the same bytes](figures.md#a-figure-that-knows-how-it-was-made).

## References

The laws, the theory of requirements, and the simulators that stand [beside this one](comparison.md),
by year; for BibTeX: `paper/paper.bib`. Where a DOI is missing it could not be checked; volume and
pages were.

"""


class Reference(NamedTuple):
    """A publication of the bibliography."""

    key: str
    authors: Tuple[str, ...]  # family names
    year: str
    text: str  # in Markdown

    def is_cited_in(self, text):
        """Return whether ``text`` names the first author and, with names alone between, the year."""
        between = r"[^;()\d]{0,60}?"
        return bool(re.search(re.escape(plain(self.authors[0])) + between + self.year, text))


def references():
    """Return the ``Reference``s of the bibliography, oldest first."""
    with open(BIBLIOGRAPHY, encoding="utf-8") as file:
        entries = re.findall(r"^@\w+\{(\w+), (.*)\}$", file.read(), re.M)
    return sorted((_reference(*each) for each in entries), key=lambda each: (each.year, each.key))


def _reference(key, fields):
    entry = {name: re.sub(r"[{}]", "", value) for name, value in FIELD.findall(fields)}
    people = [each.split(", ") for each in entry["author"].split(" and ")]
    names = ["{} {}".format(_initials(given), family) for family, given in people]
    where = "*{}*".format(entry.get("journal") or entry["booktitle"])
    if "volume" in entry:
        where += (
            " " + entry["volume"] + ("({})".format(entry["number"]) if "number" in entry else "")
        )
    if "pages" in entry:
        where += ", " + entry["pages"]
    text = "{}: {}. {}, {}.".format(", ".join(names), entry["title"], where, entry["year"])
    if "doi" in entry:
        text += " [doi:{0}](https://doi.org/{0})".format(entry["doi"])
    text = text.replace("---", "\u2014").replace("--", "\u2013")
    return Reference(key, tuple(family for family, _ in people), entry["year"], text)


def _initials(given):
    return " ".join(word[0] + "." for word in given.split())


def plain(name):
    """Return ``name`` without accents, as docstrings have it."""
    parts = unicodedata.normalize("NFKD", name.replace("\u00f8", "o"))
    return "".join(each for each in parts if not unicodedata.combining(each))


def page():
    """Return the text of the page."""
    return HEAD + "\n".join("- " + each.text for each in references()) + "\n"


if __name__ == "__main__":
    write_text(os.path.join(DOCS, "references.md"), page())
