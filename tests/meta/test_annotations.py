"""Annotations with Any, its aliases and object are found wherever they stand."""

import ast

from tools.annotations import aliases_of_any, annotations_in, count

TEXTS = {
    "p.numbers": """
from typing import Annotated, Any
Scalar = Any
Array = NDArray[Any]
Vector = Annotated[Scalar, (3,)]
Plain: TypeAlias = int
Named: TypeAlias = dict[str, Any]
table: dict[str, int] = Any
made = NewType("made", Any)
""",
    "p.user": """
from p import numbers
from p.numbers import Scalar as Number, Plain
class Record:
    first: Number
    second: "Plain"
    third: numbers.Array | None = None
def function(a: Any, b: "list[Any]", *others: object, key: int, **named: dict[str, object]) -> Number:
    inner: typing.Any = a
    return lambda x: x
async def later(a, b: tuple[Any, Number, object]) -> None: ...
""",
}
TREES = {name: ast.parse(text) for name, text in TEXTS.items()}


def test_aliases_are_followed_through_imports():
    aliases = aliases_of_any(TREES)
    assert aliases["p.numbers"] == {"Scalar", "Array", "Vector", "Named"}
    imported = {"Number", "numbers.Scalar", "numbers.Array", "numbers.Vector", "numbers.Named"}
    assert aliases["p.user"] == imported


def test_each_annotation_counts_once():
    found = count({"p.user": TREES["p.user"]}, aliases_of_any(TREES))
    assert found == {"all": 12, "Any": 4, "alias": 3, "object": 2}


def test_quoted_annotations_are_parsed():
    (found,) = annotations_in(ast.parse("x: 'list[Any]'"))
    assert ast.unparse(found) == "list[Any]"
