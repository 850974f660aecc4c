"""How far a search is, as it says itself and as a display reads it."""

import contextlib

from mrs_simulator.scenario.reading import parse_yaml
from mrs_simulator.study.search import breaking
from mrs_simulator.study.search.break_command import progress_in, tell

SCENARIO = """
poses: [[0, 0, 0], [1, 0.5, 0]]
fidelity: point_mass
limits: none
control: {protocol: consensus, rate: 10, saturation: none, parameters: {gain: 0.5}}
topology: {edges: [[1, 2]], directed: false}
duration: 1
requirements: {near: always(each pair(distance < 2 m))}
"""


def test_a_search_says_now_and_then_how_many_runs_there_were(monkeypatch, capsys):
    content, path = parse_yaml(SCENARIO, "scenario"), "scenario.yaml"
    for every, wanted in ((0.0, (4, "")), (1e9, (None, ""))):
        monkeypatch.setattr(breaking, "EVERY", every)
        search = breaking.Search(content, path, None, 1, report=tell)
        with contextlib.closing(search._cores):
            search.nominal()
            search.tried([{"control.parameters.gain": 0.1 * k} for k in (2, 3, 4)])
        assert progress_in(capsys.readouterr().err) == wanted


def test_progress_is_read_of_what_was_printed():
    assert progress_in("") == (None, "")
    printed = (
        "search: 20 runs, margin +0.2 m of near\n  law 7 runs so far\nsearch: 34 runs so far\n"
    )
    assert progress_in(printed) == (34, "margin +0.2 m of near")
    assert progress_in("search: found after 34 runs; it is shrunk\n") == (None, "")
