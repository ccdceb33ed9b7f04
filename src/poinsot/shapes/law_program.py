"""Programs of scattering laws: values and derivatives of a law on arrays of angles, written into buffers."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poinsot.functions import Scalar, less, minimum
from poinsot.shapes.scattering import Reflection, ScatteringLaw
from poinsot.taylor.compiled_sums import CompiledSums
from poinsot.taylor.graph import Graph, GraphScalar, Node, gradient, needed, operation_of, ordered

__all__ = ["FacetFormulas", "LawFormula", "Wanted", "law_formula"]

Array = NDArray[np.float64]

UFUNCS: dict[str, Callable[..., Any]] = {
    **{"add": np.add, "neg": np.negative, "mul": np.multiply, "div": np.true_divide, "pow": np.power},
    **{"sqrt": np.sqrt, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan, "tanh": np.tanh},
    **{"asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2, "rint": np.rint},
}
"""Operations that write their results into a buffer."""

ARITHMETIC = {"symbol", "add", "neg", "mul", "div", "sqrt", "less", "where"}
"""Operations that processors compute for vectors; NumPy is faster for the others."""


class Wanted(NamedTuple):
    """Sums that are wanted in addition to the brightness.

    Attributes
    ----------
    by_vectors, by_stretch : bool
        True for derivatives by the unit vectors, and by the stretch.
    others : tuple of int
        Other outputs of a `LawFormula`.
    """

    by_vectors: bool
    by_stretch: bool
    others: tuple[int, ...]


class FacetFormulas(NamedTuple):
    """Facet as formulas of a row of a table and of inputs.

    Attributes
    ----------
    columns, inputs : list of Node
        Symbols of the row, and of the inputs.
    normal : three scalars
    area, mu0, mu : scalar
        Area, and cosines of incidence and emission.
    """

    columns: list[Node]
    inputs: list[Node]
    normal: Sequence[Any]
    area: Any
    mu0: Any
    mu: Any


MAX_FORMULAS = 64
"""Largest number of formulas that are stored."""

_formulas: dict[Hashable, LawFormula] = {}


def law_formula(law: ScatteringLaw) -> LawFormula:
    """Return the traced formula of a law; laws that differ in numbers alone share it, but zeros select a formula."""
    zeros = tuple(isinstance(x, np.ndarray | float) and bool(np.all(x == 0)) for x in law.numbers)
    key = law.structure, zeros
    if key not in _formulas:
        while len(_formulas) >= MAX_FORMULAS:
            _formulas.pop(next(iter(_formulas)), None)
        _formulas[key] = LawFormula(law, zeros)
    return _formulas[key]


class LawFormula:
    """Formula of a law on symbols, split into a factor that depends on the facet and a factor that does not.

    S = factor(phase, numbers) * rest(mu0, mu, phase, numbers).

    Attributes
    ----------
    rest_numbers : tuple of int
        Numbers of the law on which the second factor depends.
    uses_phase : bool
        True if the second factor depends on the phase angle.
    """

    def __init__(self, law: ScatteringLaw, zeros: Sequence[bool]) -> None:
        self._graph = graph = Graph()
        self._mu0, self._mu, self._phase = (graph.symbol(name) for name in ("mu0", "mu", "phase"))
        self._numbers = [0.0 if is_zero else graph.input(k) for k, is_zero in enumerate(zeros)]
        light = Reflection(self._mu0, self._mu, self._phase)
        total = law.with_numbers(self._numbers).brightness(light)
        self._of_facets = self._depending([total], [self._mu0, self._mu])
        self._factor, self._rest = self._split(total)
        inside = {node.place for node in ordered([self._rest])}
        self.uses_phase = self._phase.place in inside
        self.rest_numbers = tuple(k for k, x in enumerate(self._numbers) if isinstance(x, Node) and x.place in inside)
        numbers = [x for k in self.rest_numbers if isinstance(x := self._numbers[k], Node)]
        by = [self._mu0, self._mu, self._phase, *numbers]
        self._outputs: list[GraphScalar] = [self._rest, *gradient(self._rest, by)]
        self._of_facets |= self._depending(self._outputs, [self._mu0, self._mu])
        self._programs: dict[tuple[int, ...], FacetProgram] = {}
        self._compiled: dict[Hashable, CompiledSums | None] = {}
        names = {node.name for node in ordered(self._outputs) if node.place in self._of_facets}
        self._is_arithmetic = names <= ARITHMETIC

    def _depending(self, outputs: Sequence[Scalar], by: Sequence[Node]) -> set[int]:
        found = {node.place for node in by}
        for node in ordered(outputs):
            if any(x.place in found for x in node.nodes):
                found.add(node.place)
        return found

    def _split(self, scalar: GraphScalar) -> tuple[GraphScalar, GraphScalar]:
        """Return the factors of a product that do not depend on the facet, and the other factors, as two products."""
        if not isinstance(scalar, Node) or scalar.place not in self._of_facets:
            return scalar, 1.0
        if scalar.name == "neg":
            factor, rest = self._split(scalar.operands[0])
            return -factor, rest
        if scalar.name in ("mul", "div"):
            (factor, rest), (other, others) = map(self._split, scalar.operands)
            return (factor * other, rest * others) if scalar.name == "mul" else (factor / other, rest / others)
        return 1.0, scalar

    def compiled_sums(self, wanted: Wanted, facets: Callable[[Graph], FacetFormulas]) -> CompiledSums | None:
        """Return compiled sums of A S and of its derivatives over facets; None if NumPy computes them faster.

        The inputs of the facets, the phase angle and the numbers of `rest_numbers` are the inputs. The outputs are the
        sum of A S; with derivatives by s and e the sums of A S_mu0 n and A S_mu n; with derivatives by a stretch the
        sums of A n_k^2 (S - mu0 S_mu0 - mu S_mu); and the sums of other outputs times A.
        """
        if not self._is_arithmetic:
            return None
        key = wanted, facets
        if key not in self._compiled:
            try:
                self._compiled[key] = self._compiled_sums(wanted, facets(Graph()))
            except ImportError:  # llvmlite has no wheel for every platform
                self._compiled[key] = None
        return self._compiled[key]

    def _compiled_sums(self, wanted: Wanted, facet: FacetFormulas) -> CompiledSums:
        numbers = [x for k in self.rest_numbers if isinstance(x := self._numbers[k], Node)]
        names = self._phase, *numbers
        inputs = [facet.columns[0].graph.symbol(f"number {k}") for k in range(len(names))]
        given = dict(zip((self._mu0, self._mu, *names), (facet.mu0, facet.mu, *inputs), strict=True))
        light, by_mu0, by_mu = _retraced(self._outputs[:3], given)
        outputs = [facet.area * light]
        if wanted.by_vectors:
            outputs += [facet.area * slope * n for slope in (by_mu0, by_mu) for n in facet.normal]
        if wanted.by_stretch:
            rest = facet.area * (light - facet.mu0 * by_mu0 - facet.mu * by_mu)
            outputs += [rest * n * n for n in facet.normal]
        outputs += [facet.area * x for x in _retraced([self._outputs[k] for k in wanted.others], given)]
        condition, *outputs = _retraced([less(0.0, minimum(facet.mu0, facet.mu)), *outputs], {})
        return CompiledSums(outputs, condition, facet.columns, [*facet.inputs, *inputs])

    def factor(self, phase: Scalar, numbers: Sequence[Scalar]) -> Scalar:
        """Return the factor that does not depend on the facet, for scalars of any kind."""
        (value,) = self._evaluated([self._factor], phase, dict(enumerate(numbers)))
        factor: Scalar = value
        return factor

    def program(self, outputs: tuple[int, ...]) -> FacetProgram:
        """Return the program of some outputs: the rest (0), its derivatives by mu0 (1), mu (2) and phase (3).

        The derivatives by the numbers of `rest_numbers` follow, from 4.
        """
        if outputs not in self._programs:
            chosen = [self._outputs[k] for k in outputs]
            self._programs[outputs] = FacetProgram(chosen, (self._mu0, self._mu), self._of_facets)
        return self._programs[outputs]

    def columns(self, program: FacetProgram, phase: Scalar, *numbers: Scalar) -> list[Any]:
        """Return the operands of a program that do not depend on the facet, for the numbers of `rest_numbers`."""
        return self._evaluated(program.columns, phase, dict(zip(self.rest_numbers, numbers, strict=True)))

    def _evaluated(self, outputs: Sequence[Scalar], phase: Scalar, numbers: Mapping[int, Scalar]) -> list[Any]:
        values = {node: x for k, x in numbers.items() if isinstance(node := self._numbers[k], Node)}
        return self._graph.evaluated(outputs, {self._phase: phase, **values})


def _retraced(outputs: Sequence[GraphScalar], given: Mapping[Node, Scalar]) -> list[Any]:
    """Return formulas of other nodes in place of some nodes; divisors are inverted, so that each is divided by once."""
    known: dict[int, Any] = {node.place: x for node, x in given.items()}
    for node in needed([x for x in outputs if isinstance(x, Node)], known):
        if node.name == "symbol":
            known[node.place] = node
            continue
        operands = [known[x.place] if isinstance(x, Node) else x for x in node.arguments]
        is_quotient = node.name == "div" and isinstance(operands[1], Node)
        known[node.place] = operands[0] * (1 / operands[1]) if is_quotient else operation_of(node)(*operands)
    return [known[x.place] if isinstance(x, Node) else x for x in outputs]


class FacetProgram:
    """Outputs of a formula as operations on arrays of facets, which write into buffers.

    Attributes
    ----------
    buffers : int
        Number of buffers that a call needs.
    """

    def __init__(self, outputs: Sequence[GraphScalar], angles: Sequence[Node], of_facets: set[int]) -> None:
        ends = [x.place for x in outputs if isinstance(x, Node)]
        facets = [
            x for x in needed([x for x in outputs if isinstance(x, Node)], ()) if x.place in of_facets and x.nodes
        ]
        operations = _operations(facets, ends)
        inputs = [x for _, _, operands in operations for x in (*operands, *outputs)]
        inputs += outputs
        self.columns = list({x.place: x for x in inputs if isinstance(x, Node) and x.place not in of_facets}.values())
        self._registers: dict[Hashable, int] = {}
        for x in (*angles, *self.columns):
            self._registers[x.place] = len(self._registers)
        numbers = list(dict.fromkeys(float(x) for x in inputs if not isinstance(x, Node)))
        self._numbers = numbers
        first = len(self._registers) + len(numbers)
        constants = {x: len(self._registers) + k for k, x in enumerate(numbers)}
        self._steps: list[tuple[Callable[..., Any], tuple[int, ...], int]] = []
        last = {x.place: k for k, (_, _, operands) in enumerate(operations) for x in operands if isinstance(x, Node)}
        last |= dict.fromkeys(ends, len(operations))
        free: list[int] = []
        self.buffers = 0

        def register(x: GraphScalar) -> int:
            return self._registers[x.place] if isinstance(x, Node) else constants[float(x)]

        for k, (place, function, operands) in enumerate(operations):
            taken = tuple(map(register, operands))
            ended = {self._registers[x.place] for x in operands if isinstance(x, Node) and last[x.place] == k}
            free += sorted(x for x in ended if x >= first)
            if not free:
                free.append(first + self.buffers)
                self.buffers += 1
            self._registers[place] = result = free.pop()
            self._steps.append((function, taken, result))
        self._outputs = [register(x) for x in outputs]

    def __call__(self, mu0: Array, mu: Array, columns: Sequence[Any], buffers: Sequence[Array]) -> list[Any]:
        """Return the outputs for facets, each an array in a buffer, a column, or a number."""
        registers = [mu0, mu, *columns, *self._numbers, *buffers]
        for function, operands, result in self._steps:
            function(*[registers[x] for x in operands], out=registers[result])
        return [registers[x] for x in self._outputs]


Operation = tuple[int, Callable[..., Any], tuple[GraphScalar, ...]]
"""Place of the result, function with an argument `out`, and operands."""


def _operations(facets: Sequence[Node], ends: Sequence[int]) -> list[Operation]:
    """Return the operations of nodes: a sum with a negative number is a difference, equal divisors are divided once."""
    users: dict[int, set[str]] = {}
    for node in facets:
        for x in node.nodes:
            users.setdefault(x.place, set()).add(node.name)
    subtracted = {x.place for x in facets if x.name == "neg" and users.get(x.place) == {"add"}} - set(ends)
    inverses = {x.operands[1].place: x for x in facets if x.name == "div" and x.operands[0] == 1}
    found: dict[int, Operation] = {}
    for node in facets:
        name, (*operands,) = node.name, node.arguments
        function = UFUNCS.get(name) or _buffered(operation_of(node))
        if node.place in found or node.place in subtracted:
            continue
        if name == "add" and any(isinstance(x, Node) and x.place in subtracted for x in operands):
            first, second = sorted(operands, key=lambda x: isinstance(x, Node) and x.place in subtracted)
            if isinstance(first, Node) and first.place in subtracted:  # minus the one, minus the other
                found.setdefault(first.place, (first.place, np.negative, first.operands))
            function, operands = np.subtract, [first, second.operands[0]]
        elif name == "div" and (inverse := inverses.get(getattr(operands[1], "place", -1))) not in (None, node):
            found.setdefault(inverse.place, (inverse.place, np.true_divide, inverse.operands))
            function, operands = np.multiply, [operands[0], inverse]
        found[node.place] = node.place, function, tuple(operands)
    return list(found.values())


def _buffered(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of arrays that writes its result into a buffer."""

    def written(*operands: Any, out: Array) -> None:
        np.copyto(out, function(*operands))

    return written
