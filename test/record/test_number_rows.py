"""Rows of numbers as text: the same bytes whoever writes them."""

import sys
import types

import numpy as np
import pytest

from mrs_simulator.record import number_rows


def strange(count=3000):
    draw = np.random.default_rng(0)
    numbers = draw.choice([-1.0, 1.0], count) * 10.0 ** draw.uniform(-30.0, 15.9, count)
    numbers[: count // 2] = np.round(numbers[: count // 2], 6)
    return np.concatenate([numbers, number_rows.TRICKY, -number_rows.TRICKY]).reshape(-1, 2)


@pytest.fixture()
def anew():
    number_rows._writer.cache_clear()
    yield
    number_rows._writer.cache_clear()


def test_numbers_read_back_to_the_same_value(anew):
    table = strange()
    read = [[float(value) for value in row.split(",")] for row in number_rows.rows_text(table)]
    np.testing.assert_array_equal(np.array(read), table)


def test_orjson_writes_what_python_does(anew):
    pytest.importorskip("orjson")
    assert number_rows._writer() is not number_rows.python_rows
    table = strange()
    assert number_rows.rows_text(np.asfortranarray(table)) == number_rows.python_rows(table)


def writes_json(spell):
    """Return a module that writes JSON as orjson does, with numbers as ``spell`` has them."""
    module = types.ModuleType("orjson")
    module.OPT_SERIALIZE_NUMPY = 0

    def dumps(table, option):
        rows = (",".join(map(spell, row)) for row in table.tolist())
        return "[{}]".format(",".join("[{}]".format(row) for row in rows)).encode()

    module.dumps = dumps
    return module


def short(value):
    """Return ``value`` as orjson writes it: exponents without zeros or plus, from 1e-5 on none."""
    text = repr(value)
    if "e-05" in text:
        digits = text[: -len("e-05")].replace(".", "")
        return digits[: -len(digits.lstrip("-"))] + "0.0000" + digits.lstrip("-")
    mantissa, _, exponent = text.partition("e")
    return mantissa + ("e{}".format(int(exponent)) if exponent else "")


def test_python_brings_exponents_to_that_form(anew, monkeypatch):
    monkeypatch.setitem(sys.modules, "orjson", writes_json(short))
    assert number_rows._writer() is not number_rows.python_rows
    table = strange()
    assert number_rows.rows_text(table) == number_rows.python_rows(table)


def test_who_writes_yet_otherwise_is_not_used(anew, monkeypatch):
    monkeypatch.setitem(sys.modules, "orjson", writes_json("{:.17g}".format))
    assert number_rows._writer() is number_rows.python_rows


def test_what_is_no_number_is_written_as_python_does(anew, monkeypatch):
    monkeypatch.setitem(sys.modules, "orjson", writes_json(short))
    assert number_rows.rows_text([[np.nan, 1.0], [np.inf, 2.0]]) == ["nan,1.0", "inf,2.0"]
    assert number_rows.rows_text([[1e16, 1e-7], [-1e300, 0.0]]) == ["1e+16,1e-7", "-1e+300,0.0"]


@pytest.mark.parametrize("at_once", [1, 2, 3, 5, 500])
def test_lines_hold_stamp_robot_numbers_and_end_however_many_are_made_at_once(at_once, monkeypatch):
    monkeypatch.setattr(number_rows, "AT_ONCE", at_once)
    table, ends = np.arange(10.0).reshape(5, 2), [",a%s"] * 4 + [",b"]
    form = "{{}},{},{},{}{}\n".format
    wanted = "".join(form(r + 1, 2.0 * r, 2.0 * r + 1.0, end) for r, end in enumerate(ends))
    lines = number_rows.Lines(range(1, 6), ends).texts([0.5, 1e-05, 3.0], np.stack([table] * 3))
    assert ["".join(texts) for texts in lines] == [
        wanted.format(*[stamp] * 5) for stamp in ("0.5", "1e-05", "3.0")
    ]
    assert {len(texts) for texts in lines} == {-(-5 // at_once)}
