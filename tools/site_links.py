"""For the site: links that lead out of docs/ become the path in the repository."""

import re

OUTWARDS = re.compile(r"\[([^\]]*)\]\(\.\./([^)]+)\)")


def on_page_markdown(markdown, **_):
    """Return ``markdown`` with paths in place of links to files that the site has not."""
    return OUTWARDS.sub(lambda found: "`{}`".format(found.group(2)), markdown)
