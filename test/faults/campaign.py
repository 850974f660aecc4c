#!/usr/bin/env python3
"""Run the fault matrix and write its table to docs/reliability.md.

python3 test/faults/campaign.py [--only WORD] [--keep]
"""

import argparse
import os
import subprocess
import sys
import time

import bench
import table

ROOT = os.path.dirname(os.path.dirname(bench.HERE))
PAGE = os.path.join(ROOT, "docs", "reliability.md")
HEADER = """| fault | of | time | the robots must | result | date | commit |
|---|---|---|---|---|---|---|
"""
MARK = "<!-- made by test/faults/campaign.py -->\n"


def main():
    """Run the rows that the command line chooses; exits with 0 if the robots bore all of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", metavar="WORD", help="trials with it in their name")
    parser.add_argument(
        "--keep", action="store_true", help="write the table to docs/reliability.md"
    )
    arguments = parser.parse_args()
    results, begin = [], time.time()
    for row in table.ROWS:
        if arguments.only in row.name:
            results.append((row, bench.run(row)))
            print("{:40} {}".format(row.name, results[-1][1] or row.expected), flush=True)
            if arguments.keep:
                keep(results[-1:])
    failed = sum(bool(said) for _, said in results)
    print("{} of {} failed, {:.0f} s".format(failed, len(results), time.time() - begin))
    sys.exit(1 if failed else 0)


def keep(results):
    """Write ``results``, of (row, what failed), into the page's table; other rows stay as they are."""
    commit = subprocess.check_output(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"]).decode()
    when = (time.strftime("%Y-%m-%d", time.gmtime()), commit.strip())
    with open(PAGE, encoding="utf-8") as file:
        head, _, table_before = file.read().partition(MARK)
    lines = {tuple(line.split(" | ")[:3]): line for line in table_before.splitlines()[2:]}
    for row, said in results:
        cells = (row.fault, row.victim, row.mode, row.expected, said or "held", *when)
        line = "| " + " | ".join(cells) + " |"
        lines[tuple(line.split(" | ")[:3])] = line
    known = [
        tuple("| {0.fault} | {0.victim} | {0.mode}".format(row).split(" | ")) for row in table.ROWS
    ]
    kept = [lines[key] for key in known if key in lines]
    with open(PAGE, "w", encoding="utf-8") as file:
        file.write(head + MARK + HEADER + "\n".join(kept) + "\n")


if __name__ == "__main__":
    main()
