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
