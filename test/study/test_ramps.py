"""Up to where protocols hold on robots with ramps: that it was measured as it is asked now, and is so."""

import sys

import pytest
from documentation import DOCS

from mrs_simulator.protocols import HOMES
from mrs_simulator.study.search.trials import try_variation

sys.path.insert(0, DOCS)
try:
    import make_ramps as maker
finally:
    sys.path.remove(DOCS)

# Vicsek's claim is of mean headings, which requirements do not know; Reynolds' law has no theorem.
NOT_ASKED = {"reynolds", "vicsek"}
CHEAP = ("displacement_formation", pytest.param("bearing_leaders", marks=pytest.mark.release))


def test_each_protocol_with_a_theorem_is_asked_and_measured():
    assert set(maker.asked()) == set(maker.results()) == set(HOMES) - NOT_ASKED


@pytest.mark.parametrize("name", sorted(maker.results()))
def test_what_is_found_was_measured_as_it_is_asked_now(name):
    """Else: python3 docs/make_ramps.py NAME"""
    found, given = maker.results()[name], maker.conditions(name)
    assert {key: found[key] for key in given} == given


@pytest.mark.parametrize("name", CHEAP)
def test_a_threshold_of_the_page_lies_where_the_page_says(name):
    content, path = maker.content_of(maker.conditions(name))
    axis = next(each for each in maker.results()[name]["axes"] if each["key"] == maker.DELAY)
    holds, breaks = map(float, maker.shown(*axis["breaks"]["settled"]))
    assert 0.0 < holds < breaks
    for value, broken in ((holds, False), (breaks, True)):
        assert try_variation(content, path, {maker.DELAY: value}).is_broken is broken


@pytest.mark.parametrize("name, acting", [("trajectory", False), ("consensus", True)])
def test_a_page_says_nothing_of_lost_messages_where_none_is_used(name, acting):
    content, path = maker.content_of(maker.conditions(name))
    loss = next(each for each in maker.results()[name]["axes"] if each["key"] == maker.LOSS)
    found = [try_variation(content, path, {maker.LOSS: at}).spares for at in (0.0, loss["end"])]
    assert loss["acts"] is (found[0] != found[1]) is acting
    assert ("of the messages lost" in maker.section(name)) is acting


@pytest.mark.parametrize(
    "pair, said",
    [
        ((0.2148, 0.2152), ("0.21", "0.22")),
        ((16.57, 16.54), ("17", "16")),
        ((0.0, 0.004), ("0", "0.004")),
    ],
)
def test_limits_are_rounded_each_to_its_own_side(pair, said):
    assert maker.shown(*pair) == said
