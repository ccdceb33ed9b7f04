"""Unknowns of a fit: coordinates of initial states, numbers of systems and observables, and scales of curves.

A point has the values of all unknowns for several starts. A step turns attitudes by q exp(theta / 2), and adds to the
other unknowns.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from poinsot.analysis.reading_partials import NumberNames, ObservedPartials, observed_partials
from poinsot.analysis.transition_matrix import coordinate_names
from poinsot.checked import checked
from poinsot.errors import PropagationError
from poinsot.estimation.residuals import difference_slopes, differences
from poinsot.estimation.rotation_vectors import rotated
from poinsot.functions import Vector
from poinsot.kinematics.state import State
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.observable import Observable
from poinsot.observables.readings import Readings
from poinsot.printable import quoted
from poinsot.quantities import Array
from poinsot.systems.named_parameters import Own, number_of, with_numbers
from poinsot.systems.system import System

__all__ = ["Arc", "Points", "Unknowns", "arcs_of", "deviations"]

STATE = ("state", "attitude", "angular_momentum_body", "omega_body", "offset")
"""Names of unknowns that are no numbers of records. "state" means attitude, angular momentum and variables of parts;
"offset" means one offset for each scalar curve, such as the zero point of magnitudes."""


class Arc:
    """Stretch of a motion with an initial state of its own, from which readings are taken.

    Parameters
    ----------
    *readings : Readings
        Readings with values, or plans of readings for `information`.
    state : State, optional
        Initial state. Default: the state of the fit.
    free : sequence of str
        Unknowns that belong to this arc: "state", "attitude", "angular_momentum_body", "omega_body", names of parts
        whose variables are unknown, "offset" for curves whose zero points are unknown, and names of numbers that differ
        between arcs. Relative light curves have an unknown factor each in any case.

    Raises
    ------
    ValueError
        If there are no readings.

    Examples
    --------
    >>> gyro = pt.observables.Gyro(noise=0.05)
    >>> pt.estimation.Arc(pt.observables.Readings(gyro, [0.0, 0.1]), free=["omega_body"]).free
    ('omega_body',)
    """

    @checked
    def __init__(self, *readings: Readings, state: State | None = None, free: Sequence[str] = ("state",)) -> None:
        if not readings:
            raise ValueError("readings must be given for an arc, got none. Leave the arc out.")
        self.readings, self.state, self.free = readings, state, tuple(free)


def arcs_of(data: Sequence[Readings | Arc], free: Sequence[str]) -> tuple[list[Arc], list[str]]:
    """Return the arcs of data, and the unknowns that all arcs share; readings alone are one arc."""
    if not data:
        raise ValueError("data must have readings, got none. Give a list of Readings or of Arcs.")
    arcs = [each for each in data if isinstance(each, Arc)]
    if not arcs:
        return [Arc(*(each for each in data if isinstance(each, Readings)), free=list(free))], []
    if len(arcs) < len(data):
        raise TypeError("data must be Readings or Arcs, got both. Put the readings of each motion into an Arc.")
    own = [name for name in free if name != "state"]
    return arcs, own


class Points(NamedTuple):
    """Values of all unknowns for several starts.

    Attributes
    ----------
    quaternions : array (starts, arcs, 4)
        Initial attitudes.
    others : array (starts, arcs, m)
        Initial angular momenta along the body axes and variables of parts.
    numbers : array (starts, p)
        Values of the numbers.
    scales : array (starts, curves)
        Factors and offsets of curves.
    """

    quaternions: Array
    others: Array
    numbers: Array
    scales: Array

    def at(self, starts: Sequence[int]) -> Points:
        """Return the points of some starts."""
        return Points(*(each[list(starts)] for each in self))

    def repeated(self, count: int) -> Points:
        """Return a point of one start for several starts."""
        return Points(*(np.repeat(each, count, axis=0) for each in self))


class InvalidNumbersError(ValueError):
    """Numbers that a system or an observable refuses, at a point that a fit tries."""


class Number(NamedTuple):
    """Unknown number: its label, its identity, its place among the arcs (None: shared), and its name in each arc."""

    label: str
    own: Own
    arc: int | None
    names: Mapping[int, str]


class Chart(NamedTuple):
    """Unknown coordinates of the state of an arc: places among theta, g and variables of parts, and labels."""

    columns: tuple[int, ...]
    labels: tuple[str, ...]
    by_omega: bool


class Scale(NamedTuple):
    """Unknown of a curve: label, arc, place among its readings, and kind, "factor" or "offset"."""

    label: str
    arc: int
    place: int
    kind: str


class AngularVelocity(Observable):
    """Angular velocity along the body axes, for the change from the momentum to the angular velocity as an unknown."""

    components = ("x", "y", "z")

    def reading(self, instant: Instant) -> Vector:
        """Return the angular velocity."""
        return instant.omega_body


class Unknowns:
    """Unknowns with the problem that they belong to; the interface of `least_squares.LeastSquares`.

    Parameters
    ----------
    system : System
        System of one body.
    state : State or None
        Initial state of arcs that state none.
    arcs : sequence of Arc
        Arcs with the unknowns that belong to each.
    shared : sequence of str
        Numbers that all arcs share.
    is_plan : bool
        True if the readings need no values.
    """

    def __init__(
        self, system: System, state: State | None, arcs: Sequence[Arc], shared: Sequence[str], is_plan: bool = False
    ) -> None:
        if len(system.of_bodies) > 1:
            raise ValueError(
                "system must have one body, got two. Fit the motion of one body in the field of the other."
            )
        self.system, self.arcs, self.is_plan = system, tuple(arcs), is_plan
        self.states = tuple(_checked_state(arc.state or state) for arc in arcs)
        self.observables = tuple(dict.fromkeys(each.observable for arc in arcs for each in arc.readings))
        for arc in arcs:
            for each in arc.readings:
                _check_readings(each, is_plan)
        self.charts = tuple(self._chart(i, arc) for i, arc in enumerate(arcs))
        self.numbers = tuple(self._numbers(shared))
        self.scales = tuple(self._scales())
        self.labels = (
            *(label for chart in self.charts for label in chart.labels),
            *(number.label for number in self.numbers),
            *(scale.label for scale in self.scales),
        )
        if doubled := [label for i, label in enumerate(self.labels) if label in self.labels[:i]]:
            raise ValueError(f"free must name each unknown once, got {quoted(doubled[0])} twice.")
        self.data = self._numbers_of_data()
        self.bounds: tuple[Array, Array] | None = None

    # ------------------------------------------------------------------ names

    def _prefix(self, arc: int) -> str:
        return f"arc {arc}: " if len(self.arcs) > 1 else ""

    @property
    def _of_states(self) -> tuple[str, ...]:
        return (*STATE, *(part.name for part in self.system.parts if part.size))

    def _chart(self, place: int, arc: Arc) -> Chart:
        names = [name for name in arc.free if name in self._of_states]
        if {"angular_momentum_body", "omega_body"} <= {*names} or ("state" in names and "omega_body" in names):
            raise ValueError("free must have omega_body or angular_momentum_body, got both. Leave one out.")
        full = coordinate_names(self.system)
        groups = {
            "offset": (),
            "attitude": full[:3],
            "angular_momentum_body": full[3:6],
            "omega_body": full[3:6],
            "state": full,
        }
        groups |= {part.name: tuple(x for x in full if x.startswith(f"{part.name}.")) for part in self.system.parts}
        wanted = {label for name in names for label in groups[name]}
        columns = tuple(i for i, label in enumerate(full) if label in wanted)
        by_omega, prefix = "omega_body" in names, self._prefix(place)
        labels = tuple(
            prefix + (full[i].replace("g_", "omega_") if by_omega and 3 <= i < 6 else full[i]) for i in columns
        )
        return Chart(columns, labels, by_omega)

    def _numbers(self, shared: Sequence[str]) -> list[Number]:
        every, found = NumberNames(self.system, self.observables), list[Number]()
        local = [
            NumberNames(self.system, list(dict.fromkeys(each.observable for each in arc.readings))) for arc in self.arcs
        ]
        for place, names in ((None, shared), *((i, arc.free) for i, arc in enumerate(self.arcs))):
            chosen = [name for name in names if name not in self._of_states]
            if place is None and len(chosen) < len(names):
                other = next(name for name in names if name not in chosen)
                raise ValueError(
                    f"free must name numbers that all arcs share, got {quoted(other)}. Give it to each Arc."
                )
            for label, own in every.owners(chosen).items():
                arcs = range(len(self.arcs)) if place is None else (place,)
                known = {i: name for i in arcs if (name := local[i].name_of(own)) is not None}
                found.append(Number(label if place is None else self._prefix(place) + label, own, place, known))
        return found

    def _scales(self) -> list[Scale]:
        found = []
        for i, arc in enumerate(self.arcs):
            for j, readings in enumerate(arc.readings):
                kind = "factor" if readings.observable.has_unknown_factor else "offset" if "offset" in arc.free else ""
                if kind and not readings.observable.components:
                    name = f"{kind}[{j}]" if len(arc.readings) > 1 else kind
                    found.append(Scale(self._prefix(i) + name, i, j, kind))
        return found

    def _numbers_of_data(self) -> NDArray[np.int_]:
        """Return the number of the datum of each residual; a reading with several errors is one datum."""
        rows, count = [], 0
        for arc in self.arcs:
            for readings in arc.readings:
                errors = len(readings.observable.errors) or 1
                rows.append(count + np.repeat(np.arange(len(readings)), errors))
                count += len(readings)
        return np.concatenate(rows)

    # ------------------------------------------------------------------ points

    def start(self) -> Points:
        """Return the point of the given states and numbers."""
        q = np.array([each.quaternion for each in self.states])
        others = np.array([np.concatenate([each.angular_momentum_body, *each.own.values()]) for each in self.states])
        records = (self.system.body, *self.system.forces, *self.observables)
        numbers = np.array([float(number_of(records, number.own)) for number in self.numbers])
        points = Points(q[None], others[None], numbers[None], np.ones((1, len(self.scales))))
        return self.with_best_scales(points)

    def moved(self, points: Points, steps: Array) -> Points:
        """Return the points after steps (starts, n)."""
        starts = len(steps)
        q, others = points.quaternions.copy(), points.others.copy()
        numbers = points.numbers + self._part(steps, "numbers")
        first = 0
        for i, chart in enumerate(self.charts):
            full = np.zeros((starts, 3 + others.shape[-1]))
            full[:, chart.columns] = steps[:, first : first + len(chart.columns)]
            first += len(chart.columns)
            q[:, i] = rotated(q[:, i], full[:, :3])
            if chart.by_omega:
                others[:, i] = self._with_omega(points, numbers, i, full[:, 3:])
            else:
                others[:, i] += full[:, 3:]
        return Points(q, others, numbers, points.scales + self._part(steps, "scales"))

    def chosen(self, which: NDArray[np.bool_], points: Points, others: Points) -> Points:
        """Return points where `which` is True and other points elsewhere."""
        return Points(
            *(np.where(which.reshape(-1, *(1,) * (a.ndim - 1)), a, b) for a, b in zip(points, others, strict=True))
        )

    def values(self, points: Points) -> Array:
        """Return the values of the unknowns (starts, n); the rotation vectors of attitudes are zero."""
        starts, columns = len(points.numbers), []
        for i, chart in enumerate(self.charts):
            full = np.concatenate([np.zeros((starts, 3)), points.others[:, i]], axis=1)
            if chart.by_omega:
                full[:, 3:6] = self._omega(points, i)
            columns.append(full[:, chart.columns])
        return np.concatenate([*columns, points.numbers, points.scales], axis=1)

    def _part(self, steps: Array, part: str) -> Array:
        state = sum(len(chart.columns) for chart in self.charts)
        bounds = {"numbers": (state, state + len(self.numbers)), "scales": (state + len(self.numbers), steps.shape[1])}
        return steps[:, slice(*bounds[part])]

    # ------------------------------------------------------------------ systems and states at points

    def problem_at(self, numbers: Array, arc: int) -> tuple[System, list[Observable]]:
        """Return system and observables of an arc with the numbers (p,), or with members for numbers (starts, p)."""
        own = {x.own: numbers[..., j] for j, x in enumerate(self.numbers) if x.arc in (None, arc)}
        try:
            return with_numbers(self.system, self.observables, own)
        except ValueError as error:
            raise InvalidNumbersError(str(error)) from error

    def state_at(self, system: System, quaternion: Array, others: Array, arc: int) -> State:
        """Return the initial state of an arc, or states of starts for arrays with a first axis."""
        own: dict[str, Any] = {}
        first = 3
        for part in system.parts:
            if part.size:
                own[part.name] = others[..., first : first + part.size]
                first += part.size
        time = float(self.states[arc].time)
        return system.state(quaternion, angular_momentum_body=others[..., :3], time=time, **own)

    def _omega(self, points: Points, arc: int) -> Array:
        """Return the angular velocities of starts, (starts, 3); NaN for invalid numbers."""
        found = np.full((len(points.numbers), 3), np.nan)
        valid = [i for i, row in enumerate(points.numbers) if self.are_valid(row)]
        if valid:
            some = points.at(valid)
            q, others = _squeezed(some.quaternions[:, arc]), _squeezed(some.others[:, arc])
            system, _ = self.problem_at(_squeezed(some.numbers), arc)
            found[valid] = system.omega_body(self.state_at(system, q, others, arc))
        return found

    def _with_omega(self, points: Points, numbers: Array, arc: int, steps: Array) -> Array:
        """Return momenta and variables of parts after steps of the angular velocity and of valid numbers."""
        others = points.others[:, arc] + np.pad(steps[:, 3:], ((0, 0), (3, 0)))
        valid = [i for i, row in enumerate(numbers) if self.are_valid(row)]
        if valid:
            some = points.at(valid)
            q, omega = _squeezed(some.quaternions[:, arc]), self._omega(some, arc) + steps[valid, :3]
            system, _ = self.problem_at(_squeezed(numbers[valid]), arc)
            own: Any = self.state_at(system, q, _squeezed(others[valid]), arc).own
            state = system.state(q, omega_body=_squeezed(omega), **own)
            others[valid, :3] = state.angular_momentum_body
        return others

    # ------------------------------------------------------------------ residuals

    def evaluated(self, points: Points) -> tuple[Array, Array]:
        """Return whitened residuals (starts, m) and derivatives (starts, m, n).

        They are NaN where a motion fails, or where numbers are invalid, such as moments that no rigid body has.
        """
        starts, shape = len(points.numbers), (len(points.numbers), self.data.size)
        residuals, derivatives = np.full(shape, np.nan), np.full((*shape, len(self.labels)), np.nan)
        valid = [i for i in range(starts) if self.are_valid(points.numbers[i])]
        if valid:
            residuals[valid], derivatives[valid] = self._of_valid(points.at(valid))
        return residuals, derivatives

    def _of_valid(self, points: Points) -> tuple[Array, Array]:
        starts = len(points.numbers)
        try:
            found = [self._of_arc(points, i) for i in range(len(self.arcs))]
        except PropagationError:
            if starts == 1:
                return np.full((1, self.data.size), np.nan), np.full((1, self.data.size, len(self.labels)), np.nan)
            each = [self._of_valid(points.at([i])) for i in range(starts)]
            return np.concatenate([x for x, _ in each]), np.concatenate([x for _, x in each])
        return np.concatenate([x for x, _ in found], axis=1), np.concatenate([x for _, x in found], axis=1)

    def are_valid(self, numbers: Array) -> bool:
        """Return True if numbers (p,) make systems and observables of all arcs."""
        try:
            for arc in range(len(self.arcs)):
                self.problem_at(numbers, arc)
        except InvalidNumbersError:
            return False
        return True

    def _of_arc(self, points: Points, arc: int) -> tuple[Array, Array]:
        starts, n = len(points.numbers), len(self.labels)
        rows, columns = [], []
        for place, (predicted, slopes) in enumerate(self.predictions(points, arc, self.arcs[arc].readings)):
            readings = self.arcs[arc].readings[place]
            read = predicted if readings.values is None else np.broadcast_to(readings.values, predicted.shape)
            sigma = deviations(readings)
            residuals = differences(readings.observable, read, predicted) / sigma
            J = difference_slopes(readings.observable, read, predicted, slopes) / sigma[..., None]
            if readings.values is not None:
                absent = np.isnan(readings.values).reshape(len(readings), -1).any(axis=1)
                residuals[:, absent], J[:, absent] = 0.0, 0.0
            rows.append(residuals.reshape(starts, -1))
            columns.append(J.reshape(starts, -1, n))
        return np.concatenate(rows, axis=1), np.concatenate(columns, axis=1)

    def predictions(
        self, points: Points, arc: int, plans: Sequence[Readings], is_scaled: bool = True
    ) -> list[tuple[Array, Array]]:
        """Return predicted readings (starts, n, [components]) of an arc, with derivatives by all unknowns."""
        system, observables = self.problem_at(_squeezed(points.numbers), arc)
        new = dict(zip(map(id, self.observables), observables, strict=True))
        q, others = _squeezed(points.quaternions[:, arc]), _squeezed(points.others[:, arc])
        every = [each.of(new.get(id(each.observable), each.observable)) for each in plans]
        every.append(Readings(AngularVelocity(), [float(self.states[arc].time)]))
        names = [x.names[arc] for x in self.numbers if arc in x.names]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of readings that a trial motion does not have
            found = observed_partials(system, self.state_at(system, q, others, arc), every, parameters=names)
        *each, omega = (self._of_starts(one, len(points.numbers)) for one in found)
        slopes = [
            (values, self._in_unknowns(by_start, by_numbers, omega, arc)) for values, by_start, by_numbers in each
        ]
        if not is_scaled:
            return slopes
        return [self.scaled(points, arc, place, *one) for place, one in enumerate(slopes)]

    def _of_starts(self, found: ObservedPartials, starts: int) -> tuple[Array, Array, Array]:
        each = found.values, found.by_start, found.by_parameters
        return tuple(x[None] for x in each) if starts == 1 else each  # type: ignore[return-value]

    def _in_unknowns(self, by_start: Array, by_numbers: Array, omega: tuple[Array, Array, Array], arc: int) -> Array:
        """Return the derivatives by all unknowns, from the derivatives by the state and by the numbers of an arc."""
        chart = self.charts[arc]
        if chart.by_omega:
            _, of_state, of_numbers = (x[:, 0] for x in omega)
            gap = by_start.ndim - of_state.ndim
            of_state, of_numbers = (x.reshape(len(x), *(1,) * (gap + 1), *x.shape[1:]) for x in (of_state, of_numbers))
            by_omega = by_start[..., None, 3:6] @ np.linalg.inv(of_state[..., 3:6])
            by_numbers = by_numbers - (by_omega @ of_numbers)[..., 0, :]
            parts = by_start[..., 6:] - (by_omega @ of_state[..., 6:])[..., 0, :]
            by_start = np.concatenate([by_start[..., :3], by_omega[..., 0, :], parts], axis=-1)
        slopes = np.zeros((*by_start.shape[:-1], len(self.labels)))
        first = sum(len(each.columns) for each in self.charts[:arc])
        slopes[..., first : first + len(chart.columns)] = by_start[..., chart.columns]
        state = sum(len(each.columns) for each in self.charts)
        places = [state + j for j, x in enumerate(self.numbers) if arc in x.names]
        slopes[..., places] = by_numbers
        return slopes

    def scaled(self, points: Points, arc: int, place: int, predicted: Array, slopes: Array) -> tuple[Array, Array]:
        """Return predictions of a curve with its factor or offset."""
        for j, scale in enumerate(self.scales):
            if (scale.arc, scale.place) == (arc, place):
                value = points.scales[:, j].reshape(-1, *(1,) * (predicted.ndim - 1))
                column = len(self.labels) - len(self.scales) + j
                if scale.kind == "factor":
                    slopes = slopes * value[..., None]
                    slopes[..., column] = predicted
                    return predicted * value, slopes
                slopes[..., column] = 1.0
                return predicted + value, slopes
        return predicted, slopes

    def with_best_scales(self, points: Points) -> Points:
        """Return points with the factors and offsets of least squares for the other unknowns."""
        scales = np.array(points.scales)
        for arc in dict.fromkeys(scale.arc for scale in self.scales):
            plans = self.arcs[arc].readings
            try:
                found = self.predictions(points, arc, plans, is_scaled=False)
            except PropagationError:  # of some start, whose scales stay
                continue
            for j, scale in enumerate(self.scales):
                if scale.arc == arc:
                    scales[:, j] = _best_scale(scale.kind, plans[scale.place], found[scale.place][0])
        return points._replace(scales=scales)


# ---------------------------------------------------------------------- readings


def deviations(readings: Readings) -> Array:
    """Return the standard deviations of all errors, (n, errors); one error for scalar readings."""
    errors = readings.observable.errors
    full = (len(readings), len(errors)) if errors else (len(readings),)
    return np.broadcast_to(cast("Array", readings.sigma), full).reshape(len(readings), -1)


def _best_scale(kind: str, readings: Readings, predicted: Array) -> Array:
    if readings.values is None:
        return 1 / np.mean(predicted, axis=1) if kind == "factor" else np.zeros(len(predicted))
    weights = deviations(readings).reshape(readings.values.shape) ** -2.0
    with np.errstate(invalid="ignore", divide="ignore"):
        if kind == "factor":
            products = weights * predicted
            best = np.nansum(products * readings.values, axis=1) / np.nansum(products * predicted, axis=1)
        else:
            left = weights * (readings.values - predicted)
            best = np.nansum(left, axis=1) / np.nansum(np.where(np.isnan(left), 0.0, weights), axis=1)
    return np.where(np.isfinite(best), best, 1.0)


def _checked_state(state: State | None) -> State:
    if state is None:
        raise ValueError("state must be given, got none. Give the initial state of the fit, or of each arc.")
    if state.shape:
        raise ValueError("state must be one state, got an ensemble. Give starts= for several starts.")
    return state


def _check_readings(readings: Readings, is_plan: bool) -> None:
    if readings.is_ensemble:
        raise ValueError(f"data must be readings of one body, but {readings.name} has members. Take one by isel.")
    if readings.values is None and not is_plan:
        raise ValueError(f"data must have values, but {readings.name} has none. Give values= to its Readings.")
    if readings.sigma is None:
        raise ValueError(f"data must have sigma, but {readings.name} has none. Give sigma= to its Readings.")


def _squeezed(array: Array) -> Array:
    """Return the numbers of a single start without their first axis, so that its motion is no ensemble."""
    return array[0] if len(array) == 1 else array
