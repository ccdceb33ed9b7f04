"""The state-transition matrix of a motion, parameter sensitivities, and covariance propagation.

The displacement xi = (theta, gamma), a rotation vector and a change of angular momentum along the body axes, changes
(q, g) to (q exp(theta / 2), g + gamma). The changes of the variables of parts follow. For two bodies the displacement
consists of both xi and the changes of position and momentum.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Unpack, override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted, formatted_times, rounded
from poinsot.errors import real_numbers
from poinsot.immutable import cached_property
from poinsot.integration.report import Report
from poinsot.integration.rows import Memory, Rows
from poinsot.kinematics.state import AnyState, changed
from poinsot.printable import quoted
from poinsot.propagation.arguments import checked_settings
from poinsot.propagation.column_reader import MotionRows
from poinsot.propagation.dataset import components
from poinsot.propagation.ensemble_of_results import Analysis, analysed_in_chunks
from poinsot.propagation.trajectory import Trajectory
from poinsot.propagation.variational_run import MAX_COORDINATES_TOGETHER, Derivatives, VariationalRun
from poinsot.quantities import Array, Times
from poinsot.storage.chunk_plan import Chunking, plan_of
from poinsot.systems.named_parameters import binary_size, resolve
from poinsot.systems.system import System
from poinsot.systems.times_and_states import checked_times

if TYPE_CHECKING:
    import xarray

__all__ = ["StateTransition", "coordinate_names", "state_transition"]

Share = tuple[Sequence[int], Sequence[Sequence[int]]]
"""Parameters, and groups of columns, each group the directions of one integration."""


class StateTransition(Summarized):
    """State-transition matrix Phi and sensitivities of a motion: xi(t) = Phi xi(t0) + sensitivity dp, to first order.

    For an ensemble the axis of the members is first.

    Attributes
    ----------
    motion : Trajectory
        The motion.
    parameters : tuple of str
        Names of the parameters p.
    directions : array (n, k, k + p)
        Columns of the matrix, then of the sensitivity, each divided by exp(growth).
    growth : array (n, k + p)
        Natural logarithms of the factors by which the columns are divided; they cannot overflow.
    second : array (n, k, k + p, k + p) or None
        Second derivatives of xi(t) with respect to xi(t0) and the parameters; None for order 1.

    Examples
    --------
    >>> wheel = pt.parts.ReactionWheel((0, 0, 1), 0.1)
    >>> system = pt.System(pt.Body((6.0, 8.0, 10.0)), wheel)
    >>> start = system.state((1, 0, 0, 0), omega_body=(0.8, 0.02, 0.05))
    >>> pt.analysis.state_transition(system, start, [1.0]).coordinates[3:]
    ('g_1', 'g_2', 'g_3', 'reaction_wheel.momentum')
    """

    def __init__(
        self, motion: Trajectory, parameters: tuple[str, ...], directions: Array, growth: Array, second: Array | None
    ) -> None:
        self.motion, self.parameters = motion, parameters
        self.directions, self.growth, self.second = directions, growth, second

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"State transition along a motion of {rounded(repr(self.motion.system))}", {
            "times": formatted_times(self.motion.times, self.motion.system.units["time"]),
            "parameters": ", ".join(self.parameters),
            "order": "1" if self.second is None else "2",
            "growth (ln of a column)": formatted(np.nanmax(self.growth[..., : self._k], axis=(-2, -1))),
        }

    @property
    def _k(self) -> int:
        return int(self.directions.shape[-2])

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the k coordinates xi: angles in radians, angular momenta, and the variables of parts in their units.

        k = 6 without parts. For planar motion k = 2: the rotation about the third axis and the third component of g.
        For two bodies k = 18: "primary.theta_1", ..., "secondary.g_3", "position_1", ..., "momentum_3".
        """
        axes = (3,) if self._k == 2 * len(self.motion.initial.of_bodies) else (1, 2, 3)
        return coordinate_names(self.motion.system, axes)

    @cached_property
    def _columns(self) -> Array:
        with np.errstate(over="ignore"):
            return self.directions * np.exp(self.growth)[..., None, :]

    @property
    def matrix(self) -> Array:
        """State-transition matrix Phi(t, t0), shape (n, k, k); infinite where it exceeds 1e308."""
        return self._columns[..., : self._k]

    @property
    def sensitivity(self) -> Array:
        """Derivatives of xi by the parameters, for a fixed initial state in q, g and own; shape (n, k, p)."""
        return self._columns[..., self._k :]

    @property
    def dataset(self) -> xarray.Dataset:
        """Dataset of the motion with directions, growth, matrix, sensitivity and second derivatives."""
        motion, rows = self.motion.dataset, ("member", "time")[-self.growth.ndim + 1 :]
        columns = (*self.coordinates, *self.parameters)
        found: dict[str, tuple[tuple[str, ...], Array, str]] = {
            "directions": (("coordinate", "column"), self.directions, "columns over exp(growth)"),
            "growth": (("column",), self.growth, "natural logarithm of the size of columns"),
            "matrix": (("coordinate", "initial_coordinate"), self.matrix, "state-transition matrix"),
            "sensitivity": (("coordinate", "parameter_name"), self.sensitivity, "derivatives by parameters"),
        }
        names = {"coordinate": list(self.coordinates), "initial_coordinate": list(self.coordinates)}
        names |= {"column": list(columns), "parameter_name": list(self.parameters)}
        if self.second is not None:
            names["other_column"] = list(columns)
            found["second"] = (("coordinate", "column", "other_column"), self.second, "second derivatives")
        own = {name: ((*rows, *dims), x, {"long_name": meaning}) for name, (dims, x, meaning) in found.items()}
        return motion.assign(own).assign_coords(names)

    def covariance(self, initial: ArrayLike, of_parameters: ArrayLike | None = None) -> Array:
        """Return the covariance of xi at the times, to first order: Phi P0 Phi^T + S Pp S^T, with the sensitivity S.

        Parameters
        ----------
        initial : array (k, k)
            Covariance P0 of xi at the initial time: rad^2, rad times momentum, momentum^2, ...
        of_parameters : array (p, p), optional
            Covariance Pp of the parameters, uncorrelated with the state. Default: zero.

        Returns
        -------
        array (n, k, k)
            Covariance at each time.
        """
        start = _covariance("initial", initial, self._k)
        total = self.matrix @ start @ np.swapaxes(self.matrix, -1, -2)
        if of_parameters is None:
            return np.asarray(total)
        own = _covariance("of_parameters", of_parameters, len(self.parameters))
        return np.asarray(total + self.sensitivity @ own @ np.swapaxes(self.sensitivity, -1, -2))


def coordinate_names(system: System, axes: tuple[int, ...] = (1, 2, 3)) -> tuple[str, ...]:
    """Return the names of tangent coordinates, with the rotations about some axes."""
    bodies = system.of_bodies
    rigid = [f"{body and f'{body}.'}{kind}_{i}" for body in bodies for kind in ("theta", "g") for i in axes]
    parts = (f"{part.name}.{name}" for part in system.parts for name in components(part))
    orbit = (f"{name}_{i}" for name in ("position", "momentum") for i in (1, 2, 3)) if len(bodies) > 1 else ()
    return *rigid, *parts, *orbit


@checked
def state_transition(
    system: System,
    state: AnyState,
    times: Times,
    parameters: Sequence[str] = (),
    *,
    order: int = 1,
    formulation: str | None = None,
    tolerance: float | None = None,
    threads: int | None = None,
    progress: bool | None = None,
    **chunking: Unpack[Chunking],
) -> StateTransition:
    """Return a motion with its state-transition matrix, and its derivatives with respect to parameters.

    Parameters
    ----------
    system, state, times, formulation, tolerance, threads, progress
        Same as in `propagate`. "planar" gives the two coordinates of a body that rotates about its third axis only.
    parameters : sequence of str
        Names of parameters: "body.moments[0]", "forces[0].orbit.eccentricity", or an unambiguous end such as
        "eccentricity". An orbit that several forces share counts as one.
    order : {1, 2}
        2 to compute the second derivatives, too.
    **chunking
        Same as in `propagate`; the result is then the dataset of the state transitions.

    Returns
    -------
    StateTransition
        Motion with matrix, sensitivities and covariances.

    Raises
    ------
    ValueError
        If the parameter does not exist, or belongs to an orbit that is integrated or tabulated.
    PropagationError, PropagationInterrupted
        If `propagate` raises them. A PropagationError also occurs if the motion grazes a discontinuity of a formula,
        where it has no derivative.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    >>> found = pt.analysis.state_transition(pt.System(body), start, [5.0], ["moments[0]"])
    >>> found.matrix.shape, found.sensitivity.shape, round(float(np.linalg.det(found.matrix[0])), 12)
    ((1, 6, 6), (1, 6, 1), 1.0)
    """
    if order not in (1, 2):
        raise ValueError(f"order must be 1 or 2, got {quoted(order)}.")
    if plan := plan_of(**chunking):
        given = {"parameters": parameters, "order": order, "formulation": formulation, "tolerance": tolerance}
        given, t = given | {"threads": threads}, checked_times(times, system)
        analysis = Analysis(state_transition, system, state, t, given)
        return cast("StateTransition", analysed_in_chunks(plan, analysis, progress))
    inputs = tuple(resolve(system, name) for name in parameters)
    sizes = np.array(np.broadcast_arrays(*(binary_size(system, name) for name in parameters)), dtype=int).T
    settings = checked_settings(formulation, tolerance, threads, progress)
    whole = VariationalRun.of(system, state, times, settings, Derivatives(inputs, order, sizes))
    out = _Columns(whole, order)
    report = Report(np.zeros(out.members, dtype=int))
    for some, groups in _shares(whole.size, len(inputs), order):
        of_some = Derivatives(tuple(inputs[i] for i in some), order, sizes[..., list(some)])
        run = whole if whole.size <= MAX_COORDINATES_TOGETHER else whole.repeated(len(groups), of_some)
        unit = np.eye(whole.size)
        start = np.tile(unit[np.array(groups)[:, : len(groups[0]) - len(some)]], (out.members, 1, 1))
        found = run.integrate(start, whole.times, _Share(out, run, groups))
        _add(report, found, len(groups))
        if report.interrupted:
            break
    chosen = slice(None) if whole.is_ensemble else 0
    phase = changed(out.phase, lambda x: x[chosen])
    rows, failures = MotionRows(phase), whole.failures(report)
    motion = Trajectory(system, state, whole.times, rows, whole.run(report), failures=failures)
    second = out.second[chosen] if order == 2 else None
    result = StateTransition(motion, tuple(parameters), out.directions[chosen], out.growth[chosen], second)
    whole.check(report, result)
    return result


def _shares(k: int, parameters: int, order: int) -> Iterator[Share]:
    """Yield the parameters and the groups of columns of each integration."""
    columns, inputs = range(k), range(parameters)
    if k <= MAX_COORDINATES_TOGETHER:
        yield inputs, [range(k + parameters)]
    elif order == 1:
        yield (), [[i] for i in columns]
        if parameters:
            yield inputs, [range(k, k + parameters)]
    else:  # each second derivative belongs to two columns
        yield (), [list(two) for two in itertools.combinations(columns, 2)]
        yield from (((j,), [[i, k + j] for i in columns]) for j in inputs)
        yield from ((two, [[k + j for j in two]]) for two in itertools.combinations(inputs, 2))


def _add(report: Report, found: Report, groups: int) -> None:
    """Add the report of some groups of columns; each group has the steps of the motion."""
    steps, finished = found.steps.reshape(-1, groups)[:, 0], found.finished // groups
    report.add(dataclasses.replace(found, steps=steps, stops={i // groups: stop for i, stop in found.stops.items()}))
    report.steps, report.finished, report.interrupted = steps, finished, found.interrupted


class _Columns(Memory):
    """Memory of motions with their matrices, in the units of the user."""

    def __init__(self, run: VariationalRun, order: int) -> None:
        self.members, times, k = len(run.state.time), run.times.size, run.size
        super().__init__(run.variables, self.members, run.times)
        columns, shape = k + len(run.derivatives.inputs), (self.members, times)
        self.unit = np.ones((self.members, columns))
        self.unit[:, :k] = run.units
        self.directions = np.full((*shape, k, columns), np.nan)
        self.growth = np.full((*shape, columns), np.nan)
        self.second = np.full((*shape, k, *(columns,) * 2), np.nan) if order == 2 else np.empty(shape)


class _Share:
    """Sink of the columns of some groups; the groups of a member follow each other."""

    def __init__(self, out: _Columns, run: VariationalRun, groups: Sequence[Sequence[int]]) -> None:
        self._out, self._k, self._groups = out, run.size, np.array(groups)

    def take(self, members: NDArray[np.int_], times: Array, rows: Rows) -> None:  # noqa: ARG002
        """Store the motions and columns of some members and groups."""
        out, (whom, which) = self._out, np.divmod(members, len(self._groups))
        with_motion = np.flatnonzero(which == 0)
        for name, stored in out.phase.items():
            stored[whom[with_motion]] = rows[name][with_motion]
        vectors, bent, bits = rows["vectors"], rows["pairs"], rows["exponents"]
        columns = self._groups[which]
        unit, by = out.unit[whom, None, : self._k], out.unit[whom[:, None], columns][:, None]
        vectors = vectors / unit[:, None] * by[..., None]
        sizes = np.linalg.norm(vectors, axis=-1)
        sizes[sizes == 0] = 1.0
        out.directions[whom[:, None], :, :, columns] = np.swapaxes(vectors / sizes[..., None], 1, 2)
        out.growth[whom[:, None], :, columns] = np.swapaxes(np.log(sizes) + bits * np.log(2), 1, 2)
        for i, (a, b) in enumerate(rows.pairs):
            with np.errstate(over="ignore"):
                size = by[..., a] * by[..., b] * np.exp2(bits[..., a] + bits[..., b])
                second = bent[..., i, :] / unit * size[..., None]
            first, other = columns[:, a], columns[:, b]
            out.second[whom, :, :, first, other] = out.second[whom, :, :, other, first] = second


def _covariance(name: str, value: ArrayLike, size: int) -> Array:
    matrix = real_numbers(name, value)
    if matrix.shape[-2:] != (size, size):
        raise ValueError(f"{name} must have shape ({size}, {size}), got shape {matrix.shape}.")
    slack = 1e-9 * np.max(np.abs(matrix), initial=0.0)
    if np.max(np.abs(matrix - np.swapaxes(matrix, -1, -2)), initial=0.0) > slack:
        raise ValueError(f"{name} must be symmetric, but it is not.")
    if np.min(np.linalg.eigvalsh(matrix), initial=0.0) < -slack:
        raise ValueError(
            f"{name} must have no negative eigenvalue, but one is {np.min(np.linalg.eigvalsh(matrix)):.3g}."
        )
    return matrix
