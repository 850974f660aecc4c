"""What fuzzers have found once, and what they begin with, is borne; and a finding would be told."""

import os
import random

import fuzz
import inputs
import pytest

CASES = [
    (name, file)
    for name in sorted(inputs.INPUTS)
    for file in sorted(os.listdir(os.path.join(inputs.HERE, "corpus", name)))
]


@pytest.mark.parametrize("name, file", CASES)
def test_a_kept_case_is_borne(name, file):
    with open(os.path.join(inputs.HERE, "corpus", name, file), "rb") as kept:
        assert fuzz.attempt(name, kept.read()) == ""


@pytest.mark.parametrize("name", sorted(inputs.INPUTS))
def test_an_input_bears_some_mutations(name):
    others, draw = inputs.seeds(name), random.Random(5)
    for _ in range(4):
        content = fuzz.mutated(draw, draw.choice(others), others)
        assert fuzz.attempt(name, content) == "", content


def test_what_is_not_borne_is_reported(monkeypatch):
    def raises(_):
        raise KeyError("a traceback")

    def ends(_):
        raise SystemExit(0)

    def hangs(_):
        while True:
            pass

    for wrong, said in ((raises, "KeyError"), (ends, "SystemExit"), (hangs, "TooLong")):
        monkeypatch.setattr(fuzz, "LONGEST", 0.2)
        monkeypatch.setitem(inputs.INPUTS, "twist", wrong)
        assert said in fuzz.attempt("twist", b"")
