"""Notations of mathematics, LaTeX and MathML, and the syntax in which classes state formulas as text."""

from __future__ import annotations

import ast
import html
import re
import unicodedata
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from poinsot.printable import quoted

__all__ = ["LATEX", "MATHML", "Notation", "split_name", "typeset_stated"]

GREEK = frozenset(
    unicodedata.name(chr(code)).removeprefix("GREEK SMALL LETTER ").lower()
    for code in (*range(0x3B1, 0x3C2), *range(0x3C3, 0x3CA))
)


@dataclass(frozen=True)
class Notation:
    """Templates for the parts of a formula, and a function that writes a letter.

    Attributes
    ----------
    fraction, power, subscript : str
        Templates of two expressions.
    root, brackets, norm, rate : str
        Templates of one expression; `rate` is a time derivative.
    call : str
        Template of the name of a function and its arguments.
    sum, sum_between : str
        Templates of an index, for `sum_between` also its first and last value, and a summand.
    number, power_of_ten : str
        Templates of a number, and of a mantissa and an exponent of 10.
    times, dot, cross, equals, plus, minus, comma, less : str
        Signs between expressions.
    letter : callable
        Function that writes a name, with primes at its end, without an index.
    """

    fraction: str
    power: str
    root: str
    subscript: str
    call: str
    brackets: str
    norm: str
    rate: str
    sum: str
    sum_between: str
    number: str
    power_of_ten: str
    times: str
    dot: str
    cross: str
    equals: str
    plus: str
    minus: str
    comma: str
    less: str
    letter: Callable[[str], str]

    def name(self, base: str, index: str) -> str:
        """Return the name of a variable or a parameter with its index, if it has one."""
        return self.subscript.format(self.letter(base), self.number.format(index)) if index else self.letter(base)


def split_name(name: str) -> tuple[str, str]:
    """Return the name and the index of a parameter, such as "orbit.mu", "center_of_mass[0]" or "C20".

    Examples
    --------
    >>> [split_name(name) for name in ("orbit.mu", "center_of_mass[0]", "C20")]
    [('mu', ''), ('center_of_mass', '1'), ('C', '20')]
    """
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
    subscript="{}_{{{}}}",
    call=r"\operatorname{{{}}}\left({}\right)",
    brackets=r"\left({}\right)",
    norm=r"\left|{}\right|",
    rate=r"\dot{{{}}}",
    sum=r"\sum_{{{}}} {}",
    sum_between=r"\sum_{{{} = {}}}^{{{}}} {}",
    number="{}",
    power_of_ten=r"{} \times 10^{{{}}}",
    times=r"\,",
    dot=r" \cdot ",
    cross=r" \times ",
    equals=" = ",
    plus=" + ",
    minus=" - ",
    comma=", ",
    less=" < ",
    letter=_latex_letter,
)
MATHML = Notation(
    fraction="<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>",
    power="<msup><mrow>{}</mrow><mrow>{}</mrow></msup>",
    root="<msqrt>{}</msqrt>",
    subscript="<msub>{}<mrow>{}</mrow></msub>",
    call="<mi>{}</mi><mo>(</mo>{}<mo>)</mo>",
    brackets="<mo>(</mo>{}<mo>)</mo>",
    norm="<mo>|</mo>{}<mo>|</mo>",
    rate="<mover>{}<mo>˙</mo></mover>",
    sum="<mrow><munder><mo>∑</mo>{}</munder>{}</mrow>",
    sum_between="<mrow><munderover><mo>∑</mo><mrow>{}<mo>=</mo>{}</mrow>{}</munderover>{}</mrow>",
    number="<mn>{}</mn>",
    power_of_ten="<mn>{}</mn><mo>×</mo><msup><mn>10</mn><mn>{}</mn></msup>",
    times="<mo>&#8290;</mo>",
    dot="<mo>·</mo>",
    cross="<mo>⨯</mo>",
    equals="<mo>=</mo>",
    plus="<mo>+</mo>",
    minus="<mo>−</mo>",
    comma="<mo>,</mo>",
    less="<mo>&lt;</mo>",
    letter=_mathml_letter,
)


def typeset_stated(formula: str, notation: Notation, primed: Collection[str] = (), primes: int = 0) -> list[str]:
    """Return the equations of a formula that is stated as Python, such as "N = K*cross(x, v); K = 3*mu*radius**5".

    Indices are in square brackets. `dot` and `cross` are products of vectors. `sum(x, i)` is a sum over all i, and
    `sum(x, n, 2, degree)` a sum from 2 to the degree; a sum must be the last factor of a product. `rate(x)` is a time
    derivative. A minus before a product must be before its brackets.

    Parameters
    ----------
    formula : str
        Equations, separated by semicolons.
    notation : Notation
    primed : collection of str
        Letters that get primes.
    primes : int
        Number of primes.

    Raises
    ------
    ValueError
        If the formula violates this syntax.
    """
    marks = "'" * primes
    writer = _SyntaxWriter(notation, {name: name + marks for name in primed})
    try:
        sides = ([ast.parse(side.strip(), mode="eval").body for side in each.split("=")] for each in formula.split(";"))
        return [notation.equals.join(map(writer.text, both)) for both in sides]
    except (SyntaxError, ValueError, IndexError, KeyError) as error:
        raise ValueError(
            "formula of a class must be equations of names, numbers, + - * / **, indices and calls, separated by "
            f'semicolons, such as "N = K*cross(x, v); K = 3*mu*radius**5", got {quoted(formula)}.'
        ) from error


SUM, PRODUCT_OF_VECTORS, PRODUCT, ATOM = range(4)
"""Precedence of an expression, the weakest first."""


class _SyntaxWriter:
    """Writer of the syntax tree of an expression, with brackets around operands of lower precedence."""

    def __init__(self, notation: Notation, names: Mapping[str, str]) -> None:
        self.notation, self.names = notation, names

    def text(self, node: ast.expr, least: int = SUM) -> str:
        """Return an expression, in brackets if its precedence is below the least one."""
        text, precedence = self._written(node)
        return self.notation.brackets.format(text) if precedence < least else text

    def _written(self, node: ast.expr) -> tuple[str, int]:
        """Return an expression without brackets, and its precedence."""
        match node:
            case ast.Name():
                base, index = split_name(node.id)
                return self.notation.name(self.names.get(base, base), index), ATOM
            case ast.Constant():
                return self.notation.number.format(node.value), ATOM
            case ast.Subscript():
                indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
                return self.notation.subscript.format(self.text(node.value), "".join(map(self.text, indices))), ATOM
            case ast.UnaryOp(op=ast.USub()):
                return f"{self.notation.minus.strip()}{self.text(node.operand, PRODUCT_OF_VECTORS)}", SUM
            case ast.BinOp():
                return self._operation(node)
            case ast.Call():
                return self._call(node)
        raise ValueError(node)

    def _operation(self, node: ast.BinOp) -> tuple[str, int]:
        notation = self.notation
        match node.op:
            case ast.Add():
                return f"{self.text(node.left)}{notation.plus}{self.text(node.right)}", SUM
            case ast.Sub():
                return f"{self.text(node.left)}{notation.minus}{self.text(node.right, PRODUCT_OF_VECTORS)}", SUM
            case ast.Mult():
                return f"{self.text(node.left, PRODUCT)}{notation.times}{self.text(node.right, PRODUCT)}", PRODUCT
            case ast.Div():
                return notation.fraction.format(self.text(node.left), self.text(node.right)), PRODUCT
            case ast.Pow():
                return notation.power.format(self.text(node.left, ATOM), self.text(node.right)), ATOM
        raise ValueError(node.op)

    def _call(self, node: ast.Call) -> tuple[str, int]:
        name, notation = node.func.id if isinstance(node.func, ast.Name) else "", self.notation
        if name in ("dot", "cross"):
            a, b = (self.text(each, PRODUCT) for each in node.args)
            return f"{a}{notation.dot if name == 'dot' else notation.cross}{b}", PRODUCT_OF_VECTORS
        if name in ("norm", "rate"):
            return (notation.norm if name == "norm" else notation.rate).format(self.text(node.args[0])), ATOM
        if name == "sum":
            summand, *over = node.args
            template = notation.sum_between if len(over) > 1 else notation.sum
            return template.format(*map(self.text, over), self.text(summand, PRODUCT)), PRODUCT
        return notation.call.format(name, notation.comma.join(map(self.text, node.args))), ATOM
