"""For the site: protocols by family, formulas, links out of docs/ become paths, roles plain code."""

import os
import posixpath
import re
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import site_math

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LINK = re.compile(r"\[([^\]]*)\]\((\.\./[^)]+)\)")
ROLE = re.compile(r":(?:meth|class|func|mod|attr):(?=<code>)")
FAMILY = re.compile(r"^Law: `mrs_simulator/protocols/(\w+)/", re.M)
DISPLAYED = {"protocols.md", "safety.md", "safety_filter.md", "tutorial.md", "verdict_numbers.md"}
WITHOUT_SEARCH = {
    "agreement.md",
    "agreement_dynamic.md",
    "mistakes.md",
}  # tables that would fill it
CODE = re.compile(r"^<!-- code (\w+) -->$", re.M)  # where an example's file belongs
LAW = re.compile(r"^Law: `(mrs_simulator/protocols/\S+\.py)`\.$", re.M)
TABS = re.compile(r"^<!-- tabs -->\n(.*?)^<!-- end of tabs -->$", re.M | re.S)
TAB = re.compile(r"^\*\*(.+)\*\*$", re.M)  # a line in bold begins one
PARAMETERS = '<h2 id="parameters">'  # from where on code is values, on a protocol's page


def on_config(config, **_):
    """Return ``config`` with the pages of all protocols in the navigation, a section for each family."""
    (protocols,) = (each["Protocols"] for each in config["nav"] if "Protocols" in each)
    families = {}
    for page in sorted(os.listdir(os.path.join(config["docs_dir"], "protocols"))):
        if page.endswith(".md"):
            with open(
                os.path.join(config["docs_dir"], "protocols", page), encoding="utf-8"
            ) as file:
                family = FAMILY.search(file.read()).group(1)
            families.setdefault(family.replace("_", " ").capitalize(), []).append(
                "protocols/" + page
            )
    protocols += [{family: pages} for family, pages in sorted(families.items())]
    return config


def on_page_markdown(markdown, page, **_):
    """Return ``markdown`` with paths in place of links to files that the site has not."""
    directory = posixpath.dirname(page.file.src_uri)

    def outward(found):
        target = posixpath.normpath(posixpath.join(directory, found.group(2)))
        return "`{}`".format(target[3:]) if target.startswith("../") else found.group(0)

    if page.file.src_uri == "shipped_protocols.md":
        page.meta["hide"] = ["toc"]  # its tables take the room
    if page.file.src_uri in WITHOUT_SEARCH:
        page.meta["search"] = {"exclude": True}
    markdown = CODE.sub(lambda found: _unfolded("examples", found.group(1) + ".py"), markdown)
    markdown = LAW.sub(
        lambda found: found.group(0) + "\n" + _unfolded("src", found.group(1)), markdown
    )
    markdown = TABS.sub(_tabs, markdown)
    if page.file.src_uri in DISPLAYED:
        markdown = site_math.displayed(markdown)
    return LINK.sub(outward, markdown)


def _tabs(found):
    """Return what lies between the comments as tabs; elsewhere it is read one after the other."""
    _, *parts = TAB.split(found.group(1))
    tabs = []
    for title, text in zip(parts[::2], parts[1::2]):
        lines = ["    " + line if line else "" for line in text.strip().split("\n")]
        tabs.append("\n".join(['=== "{}"'.format(title), "", *lines, ""]))
    return "\n".join(tabs)


def _unfolded(*path):
    """Return the file of Python at ``path`` in the repository, to be unfolded."""
    with open(os.path.join(ROOT, *path), encoding="utf-8") as file:
        lines = "```python\n{}```".format(file.read()).split("\n")
    return '\n??? example "The whole file"\n' + "\n".join("    " + line for line in lines) + "\n"


def on_page_content(html, page, **_):
    """Return ``html`` with laws typeset, without the names of roles, which Markdown does not know."""
    name = page.file.src_uri
    if name.startswith("protocols/") or name == "shipped_protocols.md":
        law, mark, rest = html.partition(PARAMETERS)
        html = site_math.typeset(law) + mark + rest
    return ROLE.sub("", html)
