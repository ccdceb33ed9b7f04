"""Formulas of forces and tables of systems, typeset in LaTeX and MathML."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from poinsot.display.html_text import markup_table, rounded
from poinsot.display.notation import LATEX, MATHML, Notation, typeset_stated
from poinsot.taylor.graph import Node

__all__ = [
    "ForceSummary",
    "Formula",
    "StatedFormula",
    "SystemSummary",
    "TracedFormula",
    "equations",
    "letters_of",
    "system_html",
    "system_latex",
]

MAX_SYMBOLS = 60
"""Largest number of symbols and numbers in a formula that is typeset from its nodes."""

LETTERS = {
    "q": "attitude quaternion, body to space",
    "g": "angular momentum, body axes",
    "N": "torque, body axes",
    "U": "potential energy",
    "R": "attitude, body to space",
    "I": "inertia tensor; with one number as its index, a principal moment",
    "r": "distance from the attractor",
    "u": "unit vector from the attractor, body axes",
    "x": "position from the attractor, body axes",
    "v": "velocity relative to the attractor, body axes",
    "omega": "angular velocity, body axes",
    "t": "time",
    "B": "magnetic field, body axes",
    "w": "velocity relative to the air, body axes",
    "rho": "density of the air",
    "f": "visible part of the Sun's disc",
    "s": "axes of space, resolved along the body axes",
    "P": "associated Legendre functions of the sine of the attractor's latitude, without normalisation",
    "phi": "longitude of the attractor",
    "T": "torque of a stream of unit pressure by the direction from which it comes",
    "epsilon": "vector part of the quaternion from the target to the body, q0 > 0",
    "nu": "angular velocity relative to the target, body axes",
    "h": "momentum of the part; g is the momentum of the body with the part",
    "p": "inertial angular momentum of the part along its axis",
    "sigma": "rate relative to the body",
    "alpha": "angle of the gimbal",
}
"""Meanings of the letters in formulas, except letters of parameters."""

LETTERS_OF_TWO_BODIES = {
    "I": "inertia tensor of a body",
    "m": "mass of a body; in a tide, mass of the body that raises it",
    "omega": "angular velocity of a body",
    "r": "distance of the bodies",
    "u": "unit vector from the primary to the secondary",
    "v": "velocity of the secondary relative to the primary",
    "x": "position of the secondary from the primary",
    "F": "force on the secondary, the opposite one on the primary",
    "N": "torque on the body",
    "R": "position of the barycentre from the third body",
    "y": "position from the barycentre",
}
"""Meanings that replace or complete `LETTERS` for two bodies."""

LETTERS_OF_ORBITS = frozenset("ruvxw")
"""Letters that have a prime for each orbit that precedes their orbit in the system."""


@dataclass(frozen=True)
class StatedFormula:
    """Formula that a class states as text, and the number of its orbit among the orbits of the system."""

    text: str
    orbit: int = 0


@dataclass(frozen=True)
class TracedFormula:
    """Letter of a scalar or a vector, and its components as nodes of a graph whose symbols are (name, index)."""

    letter: str
    components: Sequence[Node | float]


Formula = StatedFormula | TracedFormula


@dataclass(frozen=True)
class ForceSummary:
    """Force as plain text, with its formula if there is one."""

    kind: str
    description: str
    numbers: str
    formula: Formula | None


@dataclass(frozen=True)
class SystemSummary:
    """System as plain text and formulas.

    Attributes
    ----------
    motion : str
        Equations of motion in the syntax of `typeset_stated`; empty for two bodies.
    body : str
    forces : sequence of ForceSummary
    conserved : sequence of str
        Conserved quantities.
    two_bodies : bool
    """

    motion: str
    body: str
    forces: Sequence[ForceSummary]
    conserved: Sequence[str]
    two_bodies: bool


def equations(formula: Formula | None, notation: Notation) -> list[str]:
    """Return the equations of a formula; none if a formula from nodes is long or contains more than arithmetic.

    A parameter is typeset as its name with the number of its component as an index, variables as in `LETTERS`.

    Raises
    ------
    ValueError
        If a stated formula violates the syntax of `typeset_stated`.
    """
    if isinstance(formula, StatedFormula):
        return typeset_stated(formula.text, notation, LETTERS_OF_ORBITS, formula.orbit)
    if formula is None:
        return []
    try:
        write = _NodeWriter(notation)
        terms = notation.comma.join(map(write.sum, formula.components))
    except (NotTypesetError, RecursionError):  # a long formula may nest deeper than Python allows
        return []
    right = terms if len(formula.components) == 1 else notation.brackets.format(terms)
    return [f"{notation.letter(formula.letter)}{notation.equals}{right}"]


def letters_of(formulas: Sequence[str], two_bodies: bool) -> dict[str, str]:
    """Return the meanings of the letters in MathML formulas, except letters of parameters."""
    letters = LETTERS | LETTERS_OF_TWO_BODIES if two_bodies else LETTERS
    return {name: what for name, what in letters.items() if any(MATHML.letter(name) in each for each in formulas)}


def system_latex(system: SystemSummary) -> str:
    """Return the equations of motion, and the formulas of the forces that are short, in LaTeX."""
    formulas = (each for force in system.forces for each in equations(force.formula, LATEX))
    lines = [*_equations_of_motion(system, LATEX), *formulas]
    return "$$\\begin{gathered}" + r" \\ ".join(lines) + "\\end{gathered}$$"


def system_html(system: SystemSummary) -> str:
    """Return a table for notebooks: the formulas, the numbers in them, the conserved quantities and the letters."""
    rows = [("body", html.escape(rounded(system.body)))]
    if motion := _equations_of_motion(system, MATHML):
        rows.insert(0, ("motion", _math_lines(motion)))
    for force in system.forces:
        formula = _math_lines(equations(force.formula, MATHML)) or html.escape(rounded(force.description))
        rows.append((force.kind, f"{formula}<br>{html.escape(rounded(force.numbers))}"))
    rows.append(("conserved", html.escape("; ".join(system.conserved) or "neither energy nor a momentum")))
    if used := letters_of([cell for _, cell in rows], system.two_bodies):
        rows.append(("letters", "; ".join(f"{_math(MATHML.letter(name))} {what}" for name, what in used.items())))
    return markup_table("System", rows)


def _equations_of_motion(system: SystemSummary, notation: Notation) -> list[str]:
    return typeset_stated(system.motion, notation) if system.motion else []


def _math_lines(formulas: Sequence[str]) -> str:
    return "<br>".join(map(_math, formulas))


def _math(formula: str) -> str:
    return f"<math>{formula}</math>"


class NotTypesetError(Exception):
    """Error for a formula that is longer than `MAX_SYMBOLS`, or contains more than operations on real numbers."""


class _NodeWriter:
    """Writer of the nodes of a graph in a notation, up to a length."""

    def __init__(self, notation: Notation) -> None:
        self.notation, self.length = notation, 0

    def sum(self, x: Node | float) -> str:
        """Return a sum: terms with their signs, in alphabetical order."""
        plus, minus, text = self.notation.plus, self.notation.minus, ""
        for positive, product in sorted((self.product(term, sign) for sign, term in _terms(x)), key=lambda one: one[1]):
            text += (plus if text else "") + product if positive else minus + product
        return text.strip()

    def product(self, x: Node | float, sign: float) -> tuple[bool, str]:
        """Return the sign of a product, and its absolute value as a fraction of powers."""
        powers = Counter[Node]()
        number = sign * _gather(x, 1, powers)
        above = [self.power(base, n) for base, n in powers.items() if n > 0]
        below = [self.power(base, -n) for base, n in powers.items() if n < 0]
        if abs(number) != 1 or not above:
            above.insert(0, self.number(abs(number)))
        text = self.notation.times.join(above)
        if below:
            text = self.notation.fraction.format(text, self.notation.times.join(below))
        return number >= 0, text

    def power(self, base: Node, n: int) -> str:
        """Return a power of a factor."""
        factor = self.factor(base)
        return factor if n == 1 else self.notation.power.format(factor, self.notation.number.format(n))

    def factor(self, x: Node) -> str:
        """Return an expression that needs no further brackets as a factor."""
        self.length += 1
        if self.length > MAX_SYMBOLS or x.name in ("value", "variable", "input", "ruled"):
            raise NotTypesetError
        if x.name == "symbol":
            return self.notation.name(*x.operands[0])
        if x.name in ("add", "mul", "div", "neg"):
            return self.notation.brackets.format(self.sum(x))
        arguments = [self.sum(operand) for operand in x.operands]
        if x.name == "sqrt":
            return self.notation.root.format(*arguments)
        if x.name == "less":
            return self.notation.brackets.format(self.notation.less.join(arguments))
        return self.notation.call.format(x.name.replace("_", " "), self.notation.comma.join(arguments))

    def number(self, x: float) -> str:
        """Return a number of six digits."""
        self.length += 1
        mantissa, _, exponent = f"{x:.6g}".partition("e")
        return (
            self.notation.power_of_ten.format(mantissa, int(exponent))
            if exponent
            else self.notation.number.format(mantissa)
        )


def _terms(x: Node | float, sign: float = 1.0) -> Iterator[tuple[float, Node | float]]:
    """Yield the terms of a sum with their signs."""
    name = x.name if isinstance(x, Node) else ""
    if isinstance(x, Node) and name == "add":
        for operand in x.operands:
            yield from _terms(operand, sign)
    elif isinstance(x, Node) and name == "neg":
        yield from _terms(x.operands[0], -sign)
    else:
        yield sign, x


def _gather(x: Node | float, exponent: int, powers: Counter[Node]) -> float:
    """Return the number in a product to a power, and count the powers of the other factors."""
    if not isinstance(x, Node):
        try:
            return float(x) ** exponent
        except (ArithmeticError, TypeError, ValueError):
            raise NotTypesetError from None
    if x.name in ("mul", "div"):
        a, b = x.operands
        return _gather(a, exponent, powers) * _gather(b, exponent if x.name == "mul" else -exponent, powers)
    if x.name == "neg":
        return (-1.0) ** exponent * _gather(x.operands[0], exponent, powers)
    powers[x] += exponent
    return 1.0
