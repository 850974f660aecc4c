#!/usr/bin/env python3
"""Make the page of the examples, each with picture and result: python3 docs/make_examples.py [--text]

Runs each file of examples/ in a directory of its own: docs/examples.md and docs/images/examples/NAME.png.
With --text nothing is run: results and pictures stay.
"""

import ast
import io
import os
import re
import subprocess
import sys
import tempfile

from mrs_simulator.core.writing import write_bytes, write_text

DOCS = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(os.path.dirname(DOCS), "examples")
ORDER = (
    "tracking", "circumnavigation", "potential_fields", "hull", "neighbours_only", "own_claims",
    "wheel_odometry", "lossy_sweep", "reading_runs", "real_robots",
)  # fmt: skip
DRAWN = {"lossy_sweep": "sweep"}  # whose picture is not called like the file
WIDTH, COLOURS = 560, 48  # [px], [-] of a picture
HEAD = """# Ten studies to copy

Each is one file of fewer than 60 lines, with a law of its own or a shipped one, a picture and a result.
Copy the nearest one and change it. They need no ROS, `reading_runs` alone wants pandas:

```sh
python3 examples/tracking.py     # writes runs/tracking
```
"""
RESULT = re.compile(r"^## (\w+)\n.*?\nResult: `(.*?)`\.$", re.M | re.S)


def main():
    """Make the page, and its pictures unless the command line says ``--text``."""
    found = results() if "--text" in sys.argv else {name: ran(name) for name in ORDER}
    write_text(os.path.join(DOCS, "examples.md"), page(found))


def results():
    """Return the result of each example that the page has now, by name."""
    with open(os.path.join(DOCS, "examples.md"), encoding="utf-8") as file:
        return dict(RESULT.findall(file.read()))


def ran(name):
    """Run an example, write its picture, and return the line with its result."""
    with tempfile.TemporaryDirectory() as directory:
        script = os.path.join(EXAMPLES, name + ".py")
        done = subprocess.run(
            [sys.executable, script], cwd=directory, stdout=subprocess.PIPE, check=True
        )
        drawn = os.path.join(directory, "runs", name, DRAWN.get(name, name) + ".png")
        write_bytes(picture_path(name), reduced(drawn))
    lines = done.stdout.decode().splitlines()
    (line, *_) = [each for each in lines if re.search(r"PASSED|FAILED|NOT JUDGED|passed", each)]
    print("{:20}{}".format(name, line), flush=True)
    return line.strip()


def reduced(path):
    """Return the bytes of the picture at ``path``, ``WIDTH`` wide, with few colours."""
    from PIL import Image  # comes with matplotlib

    small = io.BytesIO()
    with Image.open(path) as picture:
        size = WIDTH, round(picture.height * WIDTH / picture.width)
        image = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)
        image.quantize(COLOURS, dither=Image.Dither.NONE).save(small, format="png", optimize=True)
    return small.getvalue()


def picture_path(name):
    """Return the path of the example's picture."""
    os.makedirs(os.path.join(DOCS, "images", "examples"), exist_ok=True)
    return os.path.join(DOCS, "images", "examples", name + ".png")


def page(found):
    """Return the text of the page with the results ``found``, by name."""
    return "\n".join([HEAD, *(section(name, found[name]) for name in ORDER)])


def section(name, result):
    """Return the section of an example: what it shows, code, picture, result."""
    with open(os.path.join(EXAMPLES, name + ".py"), encoding="utf-8") as file:
        title, *more = ast.get_docstring(ast.parse(file.read())).split("\n\n")
    said = " ".join(" ".join(more).partition("Run:")[0].split()).replace("``", "`")
    return (
        "## {0}\n\n**{1}** {2}\n\n![{1}](images/examples/{0}.png)\n\n"
        "Code: [examples/{0}.py](../examples/{0}.py).\n<!-- code {0} -->\nResult: `{3}`.\n"
    ).format(name, title, said, result)


if __name__ == "__main__":
    main()
