"""Tables of the documentation that are made of declarations are as these have them."""

import importlib.util
import os

import pytest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SPEC = importlib.util.spec_from_file_location(
    "make_tables", os.path.join(ROOT, "docs", "make_tables.py")
)
make_tables = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(make_tables)
TABLES = make_tables.tables()


@pytest.mark.parametrize("page", sorted(TABLES))
def test_the_pages_have_the_tables_of_what_is_declared(page):
    """Else: python3 docs/make_tables.py"""
    assert make_tables.made(page, TABLES[page]) == make_tables.text_of(page)


def test_a_table_without_a_place_is_named():
    with pytest.raises(ValueError, match="nodes.md: no place for a table, wanted <!-- table stag"):
        make_tables.made("nodes.md", {"stag": ""})
