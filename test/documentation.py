"""The documentation's pages, their headings and their code, and programs beside the package, for tests."""

import importlib.util
import os
import re

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
DOCS = os.path.join(ROOT, "docs")
FENCED = re.compile(r"^```.*?^```$", re.M | re.S)


def page(name):
    """Return the text of a page in docs/, or of README."""
    place = ROOT if name == "README.md" else DOCS
    with open(os.path.join(place, name), encoding="utf-8") as file:
        return file.read()


def loaded(folder, name):
    """Return the module of the program ``name`` in a ``folder`` of the repository, a fresh one."""
    spec = importlib.util.spec_from_file_location(name, os.path.join(ROOT, folder, name + ".py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def anchors(name):
    """Return the anchors of the page's headings, as the site and a forge make them."""
    headings = re.findall(r"^#+ (.+)$", FENCED.sub("", page(name)), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
