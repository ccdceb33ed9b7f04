"""Formulas of forces as mathematics, in LaTeX and MathML, written from the traces of their code."""

from __future__ import annotations

import html
import inspect
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from typing_extensions import override

from poinsot.display.html_text import markup_table, rounded
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.attitude import Attitude, matrix_of
from poinsot.mechanics.environment import Environment, Orbit, orbits_of
from poinsot.mechanics.force import Force, Potential, Torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.notation import LATEX, MATHML, Notation, split_name, written
from poinsot.mechanics.parameters import same
from poinsot.mechanics.units import DerivedUnits, in_units
from poinsot.taylor.graph import Graph, Node

__all__ = ["formula_of", "letters_of", "stated_formula", "system_html", "system_latex"]

LONGEST = 60
"""Symbols and numbers of the longest formula that is written."""

SYMBOLS = {
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
    "s": "axes of space, along those of the body",
    "P": "associated Legendre functions of the sine of the attractor's latitude, without normalisation",
    "phi": "longitude of the attractor",
    "T": "torque of a stream of unit pressure by the direction from which it comes",
    "epsilon": "vector part of the quaternion from the target to the body, q0 > 0",
    "nu": "angular velocity relative to the target, body axes",
    "h": "momentum of the part: that of the body with it is g",
    "p": "inertial angular momentum of the part along its axis",
    "sigma": "rate relative to the body",
    "alpha": "angle of the gimbal",
}
"""What letters mean that are no parameters."""

OF_PAIRS = {
    "I": "inertia tensor of a body",
    "m": "mass of a body; of a tide, that of the body which raises it",
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
"""What they mean of two bodies."""

COMPUTED = frozenset({"formula", "energy", "torque", "load", "momentum", "rates", "torque_at"})
"""What a class states, or its methods that compute it."""

OF_ORBITS = frozenset("ruvxw")
"""Letters of which each orbit has its own."""


class UnwrittenError(Exception):
    """A formula is too long to be read, or has more in it than operations on numbers."""


def formula_of(force: Any, body: Any, orbits: Sequence[Orbit], notation: Notation) -> list[str]:
    """Return the equations that a class states, or that its code computes if they are short; none elsewhere.

    A parameter is written by its name and the number of its component, what belongs to the motion as in `SYMBOLS`.
    Letters of the second and third of the orbits have primes.
    """
    if stated := stated_formula(type(force)):
        own = next(iter(orbits_of(force)), None)
        return written(stated, notation, OF_ORBITS, _place(own, orbits) if own else 0)
    try:
        write = _Writer(notation)
        left, values = _traced(force, body, orbits)
        terms = notation.operators[2].join(map(write.sum, values))
        right = terms if len(values) == 1 else notation.brackets.format(terms)
        return [f"{notation.letter(left)}{notation.equals}{right}"]
    except Exception:
        return []


def stated_formula(kind: type) -> str:
    """Return the formula that a class states, unless a class derived from it computes another one."""
    owner = next(each for each in kind.__mro__ if vars(each).keys() & COMPUTED)
    return str(vars(owner).get("formula", ""))


def _place(orbit: Orbit, orbits: Sequence[Orbit]) -> int:
    """Return the number of an orbit among those of a system."""
    return next(i for i, one in enumerate(orbits) if same(one, orbit))


def system_latex(system: Any) -> str:
    """Return the equations of motion of a body, and the formulas of its forces that are short, in LaTeX."""
    orbits = _orbits(system)
    equations = (each for force in system.forces for each in formula_of(force, system.body, orbits, LATEX))
    lines = [*_motion(system, LATEX), *equations]
    return "$$\\begin{gathered}" + r" \\ ".join(lines) + "\\end{gathered}$$"


def system_html(system: Any) -> str:
    """Return the formulas of a system as a table of a notebook, with the numbers in them and what is conserved."""
    units, orbits = DerivedUnits(system.units), _orbits(system)
    rows = [("body", html.escape(rounded(in_units(system.body, units))))]
    if motion := _motion(system, MATHML):
        rows.insert(0, ("motion", "<br>".join(map(_math, motion))))
    for force in system.forces:
        equations = formula_of(force, system.body, orbits, MATHML)
        said = "<br>".join(map(_math, equations)) or html.escape(rounded(doc_of(force)))
        rows.append((type(force).__name__, f"{said}<br>{html.escape(rounded(in_units(force, units)))}"))
    conserved = (f"{integral.symbol}: {integral.meaning}" for integral in system.integrals)
    rows.append(("conserved", html.escape("; ".join(conserved) or "neither energy nor a momentum")))
    if used := letters_of([cell for _, cell in rows], two_bodies=len(system.of_bodies) > 1):
        rows.append(("letters", "; ".join(f"{_math(MATHML.letter(name))} {what}" for name, what in used.items())))
    return markup_table("System", rows)


def letters_of(formulas: Sequence[str], two_bodies: bool) -> dict[str, str]:
    """Return what the letters in formulas in MathML mean that are no parameters."""
    letters = SYMBOLS | OF_PAIRS if two_bodies else SYMBOLS
    return {name: what for name, what in letters.items() if any(MATHML.letter(name) in each for each in formulas)}


def _motion(system: Any, notation: Notation) -> list[str]:
    """Return the equations of motion of one body; those of two have a page of their own."""
    if len(system.of_bodies) > 1:
        return []
    return written(OF_ANY if system.parts else OF_ANY + OF_RIGID, notation)


def doc_of(thing: Any) -> str:
    """Return the docstring of a class up to its parameters."""
    text = inspect.cleandoc(type(thing).__doc__ or "")
    return " ".join(re.split(r"\n\n(?=\w+\n-+\n)", text)[0].split())


def _orbits(system: Any) -> list[Orbit]:
    """Return the orbits of the forces, each once."""
    found: list[Orbit] = []
    for orbit in (orbit for force in system.forces for orbit in orbits_of(force)):
        found += [] if any(same(orbit, one) for one in found) else [orbit]
    return found


def _math(text: str) -> str:
    return f"<math>{text}</math>"


OF_ANY, OF_RIGID = "rate(q) = q*omega/2; rate(g) = cross(g, omega) + N", "; omega = I**-1*g"
"""The equations of motion of one body, and what there is beside them without parts."""


def _traced(force: Force, body: Any, orbits: Sequence[Orbit]) -> tuple[str, list[Any]]:
    """Return the letter of what a force has a formula of, and its values, traced with names."""
    if not isinstance(force, Potential | Torque):
        raise UnwrittenError
    graph = Graph()
    twin = force.with_numbers(graph.symbol(split_name(name)) for name, _ in force.number_names())
    moments = [graph.symbol(("I", str(i))) for i in (1, 2, 3)]
    numbers = [*moments, *map(float, body.numbers[3:])]
    pairs = zip(orbits_of(twin), orbits_of(force), strict=True)
    primes = {id(new): _place(old, orbits) for new, old in pairs}
    environment = _NamedEnvironment(graph, primes)
    attitude = _NamedAttitude(matrix_of([[graph.symbol(("R", f"{i}{j}")) for j in (1, 2, 3)] for i in (1, 2, 3)]))
    omega = Vector(graph.symbol(("omega", str(i))) for i in (1, 2, 3))
    instant = Instant(body.with_numbers(numbers), attitude, environment, omega_body=omega)
    if isinstance(twin, Potential):
        return "U", [twin.energy(instant)]
    return "N", list(twin.torque(instant))


class _Named(Vector):
    """A vector in space that has names along the body axes."""

    def __init__(self, graph: Graph, letter: str) -> None:
        super().__init__(graph.symbol((letter, f"s{i}")) for i in (1, 2, 3))
        self.in_body = Vector(graph.symbol((letter, str(i))) for i in (1, 2, 3))


class _NamedAttitude(Attitude):
    @override
    def to_body(self, vector: Any) -> Vector:
        return vector.in_body if isinstance(vector, _Named) else super().to_body(vector)


class _NamedEnvironment(Environment):
    """An environment in which orbits are letters."""

    def __init__(self, graph: Graph, primes: dict[int, int]) -> None:
        super().__init__(0.0)
        self.time = graph.symbol(("t", ""))
        self._graph, self._primes = graph, primes

    def _vector(self, letter: str, orbit: Orbit) -> Vector:  # type: ignore[override]
        return _Named(self._graph, letter + "'" * self._primes[id(orbit)])

    @override
    def position(self, orbit: Orbit) -> Vector:
        return self._vector("x", orbit)

    @override
    def velocity(self, orbit: Orbit) -> Vector:
        return self._vector("v", orbit)

    @override
    def direction(self, orbit: Orbit) -> Vector:
        return self._vector("u", orbit)

    @override
    def inverse_distance(self, orbit: Orbit) -> Scalar:
        return 1 / self._graph.symbol(("r" + "'" * self._primes[id(orbit)], ""))


class _Writer:
    """What writes the nodes of a graph in a notation, up to a length."""

    def __init__(self, notation: Notation) -> None:
        self.notation, self.length = notation, 0

    def sum(self, x: Any) -> str:
        """Return a sum: terms with their signs."""
        plus, minus, *_ = self.notation.operators
        text = ""
        for positive, product in sorted((self.product(term, sign) for sign, term in _terms(x)), key=lambda one: one[1]):
            text += (plus if text else "") + product if positive else minus + product
        return text.strip()

    def product(self, x: Any, sign: float) -> tuple[bool, str]:
        """Return whether a product is positive in its number, and its size as a fraction of powers."""
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
        return (
            self.atom(base) if n == 1 else self.notation.power.format(self.atom(base), self.notation.number.format(n))
        )

    def atom(self, x: Any) -> str:
        """Return what needs no brackets as a factor."""
        self.length += 1
        if self.length > LONGEST:
            raise UnwrittenError
        if not isinstance(x, Node):
            return self.number(x)
        if x.name == "symbol":
            return self.notation.name(*x.operands[0])
        if x.name in ("add", "mul", "div", "neg"):
            return self.notation.brackets.format(self.sum(x))
        if x.name in ("value", "variable", "input", "ruled"):
            raise UnwrittenError
        arguments = [self.sum(operand) for operand in x.operands]
        if x.name == "sqrt":
            return self.notation.root.format(*arguments)
        if x.name == "less":
            return self.notation.brackets.format(self.notation.operators[3].join(arguments))
        return self.notation.call.format(x.name.replace("_", " "), self.notation.operators[2].join(arguments))

    def number(self, x: float) -> str:
        self.length += 1
        mantissa, _, exponent = f"{x:.6g}".partition("e")
        return self.notation.ten.format(mantissa, int(exponent)) if exponent else self.notation.number.format(mantissa)


def _terms(x: Any, sign: float = 1.0) -> Iterator[tuple[float, Any]]:
    name = x.name if isinstance(x, Node) else ""
    if name == "add":
        for operand in x.operands:
            yield from _terms(operand, sign)
    elif name == "neg":
        yield from _terms(x.operands[0], -sign)
    else:
        yield sign, x


def _gather(x: Any, exponent: int, powers: Counter[Node]) -> float:
    """Return the number in a product to a power, and count the powers of its other factors."""
    if not isinstance(x, Node):
        return float(x) ** exponent
    if x.name in ("mul", "div"):
        a, b = x.operands
        return _gather(a, exponent, powers) * _gather(b, exponent if x.name == "mul" else -exponent, powers)
    if x.name == "neg":
        return (-1.0) ** exponent * _gather(x.operands[0], exponent, powers)
    powers[x] += exponent
    return 1.0
