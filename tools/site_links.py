"""For the site: pages of protocols by family, links out of docs/ become paths, roles plain code."""

import os
import posixpath
import re

LINK = re.compile(r"\[([^\]]*)\]\((\.\./[^)]+)\)")
ROLE = re.compile(r":(?:meth|class|func|mod|attr):(?=<code>)")
FAMILY = re.compile(r"^Law: `mrs_simulator/protocols/(\w+)/", re.M)


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

    return LINK.sub(outward, markdown)


def on_page_content(html, **_):
    """Return ``html`` without the names of roles, which Markdown does not know."""
    return ROLE.sub("", html)
