"""How mathematics is written, in LaTeX and MathML: names, fractions, sums, and formulas that classes state as text."""

from __future__ import annotations

import ast
import html
import re
import unicodedata
from collections.abc import Callable, Collection
from dataclasses import dataclass

from poinsot.printable import quoted

__all__ = ["LATEX", "MATHML", "Notation", "split_name", "written"]

GREEK = frozenset(
    unicodedata.name(chr(code)).removeprefix("GREEK SMALL LETTER ").lower()
    for code in (*range(0x3B1, 0x3C2), *range(0x3C3, 0x3CA))
)


@dataclass(frozen=True)
class Notation:
    """How mathematics is written: templates of its parts, and how a name is."""

    fraction: str
    power: str
    root: str
    below: str
    call: str
    brackets: str
    size: str
    rate: str
    total: str
    total_between: str
    number: str
    ten: str
    times: str
    dot: str
    cross: str
    equals: str
    operators: tuple[str, str, str, str]
    letter: Callable[[str], str]

    def name(self, base: str, index: str) -> str:
        """Return the name of a variable or a parameter."""
        return self.below.format(self.letter(base), self.number.format(index)) if index else self.letter(base)


def split_name(name: str) -> tuple[str, str]:
    """Return the name and the index of a parameter: "orbit.mu", "center_of_mass[0]", "C20"."""
    word, *places = re.split(r"[\[\]]+", name.rpartition(".")[2].rstrip("]"))
    if letter := re.fullmatch(r"([A-Za-z])(\d+)", word):
        return letter[1], letter[2]
    return word, "".join(str(int(place) + 1) for place in places)


def _latex_letter(base: str) -> str:
    word = base.rstrip("'")
    primes = base[len(word) :]
    if word in GREEK:
        return f"\\{base}"
    return base if len(word) == 1 else rf"\mathrm{{{word.replace('_', '~')}}}{primes}"


def _mathml_letter(base: str) -> str:
    word = base.rstrip("'")
    return f"<mi>{html.escape(_shown(word))}{'′' * (len(base) - len(word))}</mi>"


def _shown(word: str) -> str:
    return unicodedata.lookup(f"GREEK SMALL LETTER {word}") if word in GREEK else word.replace("_", " ")


LATEX = Notation(
    fraction=r"\frac{{{}}}{{{}}}",
    power="{{{}}}^{{{}}}",
    root=r"\sqrt{{{}}}",
    below="{}_{{{}}}",
    call=r"\operatorname{{{}}}\left({}\right)",
    brackets=r"\left({}\right)",
    size=r"\left|{}\right|",
    rate=r"\dot{{{}}}",
    total=r"\sum_{{{}}} {}",
    total_between=r"\sum_{{{} = {}}}^{{{}}} {}",
    number="{}",
    ten=r"{} \times 10^{{{}}}",
    times=r"\,",
    dot=r" \cdot ",
    cross=r" \times ",
    equals=" = ",
    operators=(" + ", " - ", ", ", " < "),
    letter=_latex_letter,
)
MATHML = Notation(
    fraction="<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>",
    power="<msup><mrow>{}</mrow><mrow>{}</mrow></msup>",
    root="<msqrt>{}</msqrt>",
    below="<msub>{}<mrow>{}</mrow></msub>",
    call="<mi>{}</mi><mo>(</mo>{}<mo>)</mo>",
    brackets="<mo>(</mo>{}<mo>)</mo>",
    size="<mo>|</mo>{}<mo>|</mo>",
    rate="<mover>{}<mo>˙</mo></mover>",
    total="<mrow><munder><mo>∑</mo>{}</munder>{}</mrow>",
    total_between="<mrow><munderover><mo>∑</mo><mrow>{}<mo>=</mo>{}</mrow>{}</munderover>{}</mrow>",
    number="<mn>{}</mn>",
    ten="<mn>{}</mn><mo>×</mo><msup><mn>10</mn><mn>{}</mn></msup>",
    times="<mo>&#8290;</mo>",
    dot="<mo>·</mo>",
    cross="<mo>⨯</mo>",
    equals="<mo>=</mo>",
    operators=tuple(f"<mo>{sign}</mo>" for sign in ("+", "−", ",", "&lt;")),  # type: ignore[arg-type]
    letter=_mathml_letter,
)


def written(formula: str, notation: Notation, primed: Collection[str] = (), primes: int = 0) -> list[str]:
    """Return the equations of a formula that is stated as Python, such as "N = K*cross(x, v); K = 3*mu*radius**5".

    Indices are in square brackets, `dot` and `cross` products of vectors, `sum(x, i)` goes over all i and
    `sum(x, n, 2, degree)` from 2 to the degree, as the last factor of a product; `rate(x)` is a time derivative. A
    minus before a product is written before its brackets. `primed` letters get primes.

    Raises
    ------
    ValueError
        If it is not written so.
    """
    marks = "'" * primes
    writer = _Writer(notation, {name: name + marks for name in primed})
    try:
        sides = ([ast.parse(side.strip(), mode="eval").body for side in each.split("=")] for each in formula.split(";"))
        return [notation.equals.join(map(writer.text, both)) for both in sides]
    except (SyntaxError, ValueError, IndexError, KeyError) as error:
        raise ValueError(
            "formula of a class must be equations of names, numbers, + - * / **, indices and calls, separated by "
            f'semicolons, such as "N = K*cross(x, v); K = 3*mu*radius**5", got {quoted(formula)}.'
        ) from error


SUM, PRODUCT_OF_VECTORS, PRODUCT, ATOM = range(4)
"""How tightly an expression holds together."""

WRITTEN = frozenset({"name", "constant", "subscript", "unaryop", "binop", "call"})
"""The kinds of expressions."""


class _Writer:
    """Writes the syntax tree of an expression, with brackets where it would read otherwise."""

    def __init__(self, notation: Notation, names: dict[str, str]) -> None:
        self.notation, self.names = notation, names

    def text(self, node: ast.expr, least: int = SUM) -> str:
        """Return an expression that holds together at least so tightly."""
        kind = type(node).__name__.lower()
        if kind not in WRITTEN:
            raise ValueError(kind)
        text, held = getattr(self, f"_{kind}")(node)
        return self.notation.brackets.format(text) if held < least else str(text)

    def _name(self, node: ast.Name) -> tuple[str, int]:
        base, index = split_name(node.id)
        return self.notation.name(self.names.get(base, base), index), ATOM

    def _constant(self, node: ast.Constant) -> tuple[str, int]:
        return self.notation.number.format(node.value), ATOM

    def _subscript(self, node: ast.Subscript) -> tuple[str, int]:
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        return self.notation.below.format(self.text(node.value), "".join(map(self.text, indices))), ATOM

    def _unaryop(self, node: ast.UnaryOp) -> tuple[str, int]:
        if not isinstance(node.op, ast.USub):
            raise ValueError(node.op)
        return f"{self.notation.operators[1].strip()}{self.text(node.operand, PRODUCT_OF_VECTORS)}", SUM

    def _binop(self, node: ast.BinOp) -> tuple[str, int]:
        notation = self.notation
        match node.op:
            case ast.Add():
                return f"{self.text(node.left)}{notation.operators[0]}{self.text(node.right)}", SUM
            case ast.Sub():
                return f"{self.text(node.left)}{notation.operators[1]}{self.text(node.right, PRODUCT_OF_VECTORS)}", SUM
            case ast.Mult():
                return f"{self.text(node.left, PRODUCT)}{notation.times}{self.text(node.right, PRODUCT)}", PRODUCT
            case ast.Div():
                return notation.fraction.format(self.text(node.left), self.text(node.right)), PRODUCT
            case ast.Pow():
                return notation.power.format(self.text(node.left, ATOM), self.text(node.right)), ATOM
        raise ValueError(node.op)

    def _call(self, node: ast.Call) -> tuple[str, int]:
        name, notation = getattr(node.func, "id", ""), self.notation
        if name in ("dot", "cross"):
            a, b = (self.text(each, PRODUCT) for each in node.args)
            return f"{a}{getattr(notation, name)}{b}", PRODUCT_OF_VECTORS
        if name in ("norm", "rate"):
            return {"norm": notation.size, "rate": notation.rate}[name].format(self.text(node.args[0])), ATOM
        if name == "sum":
            summand, *over = node.args
            template = notation.total_between if len(over) > 1 else notation.total
            return template.format(*map(self.text, over), self.text(summand, PRODUCT)), PRODUCT
        return notation.call.format(name, notation.operators[2].join(map(self.text, node.args))), ATOM
