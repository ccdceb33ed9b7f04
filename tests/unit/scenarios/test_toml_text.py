"""The line of every key, and texts that must not take long."""

import re
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from poinsot.scenarios.toml_text import lines_of, parsed_toml

TEXT = '''\
title = "a # b = [c]"  # d = 1
[body]
moments = [
  1,  # one, two
  2, 3]
[[forces]]
type = "A"
field = {a = 1, b = [1, {c = 2}], "d e" = 'f'}
[[forces]]
type = """x
[no]
no = 1"""
[forces.field]
C = [[1, 2],
 [3, 4]]
[orbits."my orbit"]
a.b = 1.5e3
d = 1979-05-27T07:32:00Z
'''


def test_lines_of_keys_and_tables():
    lines = {path: line for path, line in lines_of(TEXT).items() if path[:2] != ("forces", 0) or len(path) < 5}
    assert lines == {
        ("title",): 1,
        ("body",): 2,
        ("body", "moments"): 3,
        ("forces",): 6,
        ("forces", 0): 6,
        ("forces", 0, "type"): 7,
        ("forces", 0, "field"): 8,
        ("forces", 0, "field", "a"): 8,
        ("forces", 0, "field", "b"): 8,
        ("forces", 0, "field", "d e"): 8,
        ("forces", 1): 9,
        ("forces", 1, "type"): 10,
        ("forces", 1, "field"): 13,
        ("forces", 1, "field", "C"): 14,
        ("forces", 1, "field", "C", 0): 14,
        ("forces", 1, "field", "C", 1): 15,
        ("orbits", "my orbit"): 16,
        ("orbits", "my orbit", "a"): 17,
        ("orbits", "my orbit", "a", "b"): 17,
        ("orbits", "my orbit", "d"): 18,
    }
    assert lines_of(TEXT)["forces", 0, "field", "b", 1, "c"] == 8


KEYS = st.text("abcxyz_-019", min_size=1, max_size=6)
SCALARS = st.one_of(
    st.integers(-9, 9).map(str),
    st.floats(-9, 9).map(lambda x: repr(float(x))),
    st.sampled_from(["true", '"a = [1]"', "'# no'", '"""two\nlines"""', "'''\n'''", '"\\""', "1979-05-27 07:32:00"]),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda items: "[" + ",\n ".join(items) + "]"),
        st.dictionaries(KEYS, SCALARS.filter(lambda text: "\n" not in text), max_size=3).map(
            lambda pairs: "{" + ", ".join(f"{key} = {value}" for key, value in pairs.items()) + "}"
        ),
    ),
    max_leaves=6,
)
TABLES = st.dictionaries(KEYS, st.dictionaries(KEYS, VALUES, max_size=3), max_size=4)


@given(TABLES, st.booleans())
def test_every_key_has_the_line_on_which_it_was_written(tables, several):
    """The line of each key of a text that is written here, where the lines are counted."""
    text, written = "", {}
    for name, pairs in tables.items():
        text += f"# {name} = 1\n" + (f"[[{name}]]\n" if several else f"[ {name} ]\n")
        table = (name, 0) if several else (name,)
        written[table] = text.count("\n")
        for key, value in pairs.items():
            written[*table, key] = text.count("\n") + 1
            text += f"{key} = {value}  # no = 1\n"
    found = lines_of(text)
    assert parsed_toml(text, "it") is not None
    assert {path: found[path] for path in written} == written


LONG = {
    "a million keys": "".join(f"k{i} = 1\n" for i in range(1_000_000)),
    "keys on one line": "a." * 60_000 + "a = 1",
    "quoted keys": 'a."b"' + ' ."c"' * 30_000 + " = 1",
    "long header": "[" + "a." * 60_000 + "a]",
    "a million tables": "[t]\n" * 1_000_000,
    "tables of one list": "[[t]]\n" * 200_000,
    "inline tables": "a = [" + "{b = 1}," * 100_000 + "]",
    "a million numbers": "a = [" + "1," * 1_000_000 + "]",
    "brackets": "a = " + "[" * 4000,
    "open text": 'a = """' + '\\"' * 400_000,
    "open quotes": "''" * 400_000,
    "no line break": "a" * 999_999,
    "spaces": "a ." + " " * 900_000 + "=",
    "digits": "a = " + "9" * 900_000,
    "other bytes": "\0" * 100_000,
    "returns": "\r" * 900_000,
}


@pytest.mark.parametrize("case", LONG)
def test_text_that_is_no_scenario_is_refused_in_a_second(case):
    began = time.process_time()
    with pytest.raises(ValueError, match=r"^it.* must .* (but|got) .*\.$"):
        parsed_toml(LONG[case], "it")
    assert time.process_time() - began < 1


@given(st.text(max_size=60))
def test_any_text_ends_in_tables_or_a_sentence(text):
    try:
        parsed_toml(text, "it")
    except ValueError as error:
        message = str(error)
    else:
        lines_of(text)
        return
    assert re.match(r"it(, line \d+:.*)? must ", message, re.DOTALL)
