"""YAML as people write it: numbers and merge keys as they are meant, and no text that grows, nests or crashes."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from soup_msgs_py.errors import InputError
from soup_msgs_py.reading.yaml_text import DEEPEST, MOST_VALUES, load_yaml


def load(text: str) -> object:
    return load_yaml(text, "file.yaml", "", "YAML")


def refusal(text: str) -> str:
    with pytest.raises(InputError) as caught:
        load(text)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 1000
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("1e6", 1_000_000),
        ("-2E3", -2000),
        ("1.5e3", 1500),
        (".5e1", 5),
        ("1e-3", 0.001),
        ("1.0e+3", 1000),
        ("1e22", 1e22),
    ],
)
def test_a_number_with_an_exponent_is_a_number(text: str, number: float):
    assert load(text) == number
    assert isinstance(load(text), int) == (number == int(number) and abs(number) < 2**53)


@pytest.mark.parametrize("text", ["1e", "e1", "1_e3", "E0 T1", "'1e6'"])
def test_what_only_looks_like_one_stays_a_text(text: str):
    assert load(text) == text.strip("'")


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_number_that_python_writes_is_read_as_it_was(number: float):
    assert load(repr(number)) == number


def test_a_merge_key_brings_in_what_is_not_written():
    assert load("base: &b {x: 1, y: 2}\nown: {<<: *b, y: 3}") == {"base": {"x": 1, "y": 2}, "own": {"x": 1, "y": 3}}
    assert "the key '<<' twice" in refusal("{<<: {a: 1}, <<: {b: 2}}")
    assert "the key 'a' twice" in refusal("{a: 1, <<: {b: 2}, a: 2}")


def test_aliases_that_stand_for_too_much_are_refused_before_they_are_written_out():
    for kind in ("[{}]", "{{<<: [{}]}}"):
        begin = "a0: &a0 {x: 1}\n"
        bomb = [f"a{k}: &a{k} {kind.format(','.join([f'*a{k - 1}'] * 10))}\n" for k in range(1, 12)]
        assert f"more than {MOST_VALUES} values, aliases written out" in refusal(begin + "".join(bomb))
    assert "*a within what it stands for" in refusal("&a [*a]")


def test_too_many_values_and_too_deep_ones_are_refused():
    assert f"more than {MOST_VALUES} values" in refusal(f"[{'1,' * (MOST_VALUES + 1)}]")
    assert f"more than {DEEPEST} values in one another" in refusal("[" * 100_000)


@pytest.mark.parametrize(
    "text", ["!!bool x", "!!int ''", "!!timestamp x", "!!float x", "2001-99-99", "9" * 5000, "a\0b"]
)
def test_a_value_that_is_none_is_told_in_one_line(text: str):
    assert refusal(text).startswith("file.yaml: found ")


@given(st.text(alphabet="{}[]:,&*!<>-?|'\"\n\t #a1e.~%@`=", max_size=60))
def test_any_text_is_a_value_or_one_line(text: str):
    try:
        load(text)
    except InputError as error:
        assert "\n" not in str(error)
