"""Tables of the documentation that are made of declarations are as these have them."""

import pytest
from documentation import loaded

make_tables = loaded("docs", "make_tables")
TABLES = make_tables.tables()


@pytest.mark.parametrize("page", sorted(TABLES))
def test_the_pages_have_the_tables_of_what_is_declared(page):
    """Else: python3 docs/make_tables.py"""
    assert make_tables.made(page, TABLES[page]) == make_tables.text_of(page)


def test_a_table_without_a_place_is_named():
    with pytest.raises(ValueError, match="nodes.md: no place for a table, wanted <!-- table stag"):
        make_tables.made("nodes.md", {"stag": ""})


make_speeds = loaded("docs", "make_speeds")


def kept(*figures):
    """Return rows of a history as ``make_speeds.newest`` does, of keys and values."""
    fixed = {"commit": "abc", "cpu": "a processor", "cores": "2", "versions": "python"}
    return {
        key: dict(fixed, value=str(value), date="2026-11-2{}".format(day))
        for key, value, day in figures
    }


def test_what_was_not_measured_has_no_row_nor_column():
    table = make_speeds.by_size("x", "b", (7, 100), (("one", "first"), ("two", "second")))
    rows = kept((("b", "second", 7), 1234.5, 1))
    assert make_speeds.table_of(*table, rows).splitlines() == [
        "| x | 7 robots |",
        "|---|---|",
        "| two | 1,234 |",
        "",
        "Measured on 2026-11-21 of abc: a processor, 2 cores, python.",
    ]
    for text in (make_speeds.table_of(*table, {}), make_speeds.growth({})):
        assert text == "Not measured yet on this machine."


def test_of_a_peer_the_version_measured_last_is_told():
    rows = kept(
        (("peers", "Stage 4.4.0", 7), 300.0, 2),
        (("peers", "Stage 4.3.0", 7), 200.0, 1),
        (("peers", "Stage 4.3.0", 100), 20.0, 1),
    )
    assert make_speeds.newest_peers(rows) == {"Stage": ("Stage 4.4.0", (7,))}
    ((text, case),) = make_speeds.peer_lines(rows, 7)
    assert text.startswith("Stage 4.4.0: ") and case == "Stage 4.4.0"
    assert not make_speeds.peer_lines(rows, 100)
