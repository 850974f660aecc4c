#!/usr/bin/env python3
"""Mutate every input of the product for a stated time, and keep what it cannot bear.

    python3 test/fuzz/fuzz.py [--seconds 60] [--only scenario] [--seed N]

Each input gets the same share of the time.  A case that ends in anything but a result or a message,
takes longer than a few seconds, or too much memory, is written to ``test/fuzz/corpus/INPUT/`` and told
with its traceback; the tests try all of the corpus again.
"""

import argparse
import contextlib
import hashlib
import io
import os
import random
import re
import resource
import signal
import sys
import time
import traceback

import inputs

LONGEST = 10.0  # [s] of processor time of one case
MEMORY = 3 << 30  # [bytes] that one case may need beyond what the program has
TOKEN = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?|\w+|\s+|.", re.S)
ODD = [
    b"nan", b".nan", b"inf", b"-1", b"0", b"1e308", b"-1e308", b"1e-308", b"99999999999999999999",
    b"0x" + b"f" * 4000, b"null", b"~", b"true", b"''", b"[]", b"{}", b"&a [*a]", b"*a", b"!!python/none",
    b"\x00", b"\xff", b"../../../etc/passwd", b"/dev/zero",
    b"\xe2\x80\xae", b"[" * 200, b"{a: " * 100, b"x" * 10000,
]  # fmt: skip


class TooLong(BaseException):
    """A case that does not end."""


def mutated(draw, content, others):
    """Return ``content`` with a few changes: of bytes, of words, or with parts of another."""
    for _ in range(draw.choice([1, 1, 2, 3, 8])):
        content = draw.choice([_bytes, _words, _words, _words, _spliced])(draw, content, others)
    return content


def _bytes(draw, content, _):
    changed = bytearray(content or b" ")
    for _ in range(draw.choice([1, 2, 10])):
        changed[draw.randrange(len(changed))] = draw.randrange(256)
    return bytes(changed)


def _words(draw, content, _):
    words = TOKEN.findall(content[:200000]) or [b" "]
    at = draw.randrange(len(words))
    how = draw.randrange(4)
    if how == 0:
        words[at] = draw.choice(ODD)
    elif how == 1:
        del words[at : at + draw.choice([1, 1, 5, 50])]
    elif how == 2:
        words[at:at] = words[at : at + draw.choice([1, 5, 50])]
    else:
        other = draw.randrange(len(words))
        words[at], words[other] = words[other], words[at]
    return b"".join(words) + content[200000:]


def _spliced(draw, content, others):
    other = draw.choice(others)
    begin, end = sorted(draw.randrange(len(other) + 1) for _ in range(2))
    at = draw.randrange(len(content) + 1)
    return content[:at] + other[begin : min(end, begin + 2000)] + content[at:]


def attempt(name, content):
    """Try one case; return "" if it was borne, else the traceback."""

    def give_up(*_):
        raise TooLong("longer than {:g} s".format(LONGEST))

    signal.signal(signal.SIGVTALRM, give_up)
    signal.setitimer(signal.ITIMER_VIRTUAL, LONGEST)
    try:
        with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
            inputs.check(name, content)
    except KeyboardInterrupt:
        raise
    except BaseException:
        return traceback.format_exc()
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
    return ""


def fuzz(name, seconds, draw):
    """Fuzz one input for ``seconds``; return how many cases were tried and the tracebacks by place."""
    others = inputs.seeds(name)
    end, count, found = time.monotonic() + seconds, 0, {}
    while time.monotonic() < end:
        content = mutated(draw, draw.choice(others), others)
        said, count = attempt(name, content), count + 1
        place = re.sub(r"0x\w+", "", said.strip().splitlines()[-2] if said else "")
        if said and place not in found:
            label = hashlib.sha256(content).hexdigest()[:12]
            found[place] = said
            print("{}\nkept: {}\n".format(said, inputs.keep(name, content, label)), flush=True)
    return count, found


def main():
    """Fuzz what the command line names; exits with 1 if something was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="in all (default: 60)")
    parser.add_argument("--only", choices=sorted(inputs.INPUTS), help="one input alone")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    arguments = parser.parse_args()
    now = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (now + MEMORY, now + MEMORY))
    names = [arguments.only] if arguments.only else sorted(inputs.INPUTS)
    draw, worst = random.Random(arguments.seed), 0
    print("seed {}".format(arguments.seed))
    os.chdir(os.path.dirname(inputs.HERE))  # names of files that come up lead nowhere
    for name in names:
        count, found = fuzz(name, arguments.seconds / len(names), draw)
        print("{:10} {:8} cases, {} found".format(name, count, len(found)), flush=True)
        worst += len(found)
    sys.exit(1 if worst else 0)


if __name__ == "__main__":
    main()
