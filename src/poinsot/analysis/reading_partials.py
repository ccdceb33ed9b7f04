"""Readings of observables with exact partial derivatives with respect to the initial state and to parameters.

The formula of an observable is evaluated once on the nodes of a graph. Its gradient gives C, the derivatives with
respect to the tangent coordinates xi of the state at the time of the reading, and D, the explicit derivatives with
respect to parameters at fixed q, g and variables of parts. With the state-transition matrix Phi and the sensitivity S,

    d reading / d xi(t0) = C Phi,    d reading / d p = C S + D + (d reading / d te) d te / d p.

The last term belongs to the light time: te is the time at which the light left the body.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, cast, overload

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.analysis.transition_matrix import StateTransition, coordinate_names, state_transition
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted_times
from poinsot.functions import Scalar, Vector
from poinsot.integration.variational import TangentSpace, TurningBody
from poinsot.kinematics.attitude import Attitude, matrix_of
from poinsot.kinematics.state import AnyState, State, changed, state_of
from poinsot.mechanics.environment import Environment, Orbit, orbits_of
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.light_time import speed_of_light
from poinsot.mechanics.observable import Observable, observables_by_name
from poinsot.observables.readings import Readings
from poinsot.printable import quoted
from poinsot.propagation.observe import checked_observables
from poinsot.propagation.readings_along import (
    ReadingsOfMembers,
    absent_counts,
    absent_readings,
    hidden_readings,
    refuse_unfit,
    warn_of_absent,
)
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array, Times
from poinsot.records.members import expanded, members_of
from poinsot.records.units import DerivedUnits
from poinsot.systems.dynamics import AnyDynamics, scalars
from poinsot.systems.named_parameters import (
    Own,
    names_of_numbers,
    names_of_system,
    refuse_integrated,
    refuse_name_of_number,
)
from poinsot.systems.system import System
from poinsot.systems.times_and_states import checked_times, common_members
from poinsot.taylor.graph import Graph, GraphScalar, Node, gradient, tangents

if TYPE_CHECKING:
    import xarray

__all__ = ["NumberNames", "ObservedPartials", "observed_partials"]


class ObservedPartials(Summarized):
    """Readings of an observable with their partial derivatives.

    Attributes
    ----------
    readings : Readings
        The readings.
    coordinates : tuple of str
        Names of the k coordinates of the initial state, as in `StateTransition`: a rotation vector along the body axes
        (radians), the change of the angular momentum along the body axes, and the variables of parts.
    parameters : tuple of str
        Full names of the p parameters.
    by_start : array (n, k), or (n, components, k)
        Derivatives with respect to the coordinates of the initial state; members are first.
    by_parameters : array (n, p), or (n, components, p)
        Derivatives with respect to the parameters, for a fixed initial state in q, g and the variables of parts.

    Examples
    --------
    >>> gyro = pt.observables.Gyro()
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    >>> found = pt.analysis.observed_partials(pt.System(body), start, gyro, [0.0, 5.0], ["moments[0]"])
    >>> found.dataset["by_parameters"].dims
    ('time', 'component', 'parameter_name')
    """

    def __init__(
        self,
        readings: Readings,
        coordinates: tuple[str, ...],
        parameters: tuple[str, ...],
        by_start: Array,
        by_parameters: Array,
    ) -> None:
        self.readings, self.coordinates, self.parameters = readings, coordinates, parameters
        self.by_start, self.by_parameters = by_start, by_parameters

    @property
    def values(self) -> Array:
        """Values of the readings."""
        return np.asarray(self.readings.values)

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"Partial derivatives of readings of {self.readings.name}", {
            "times": formatted_times(self.readings.times, self.readings.attributes["time_units"]),
            "coordinates": ", ".join(self.coordinates),
            "parameters": ", ".join(self.parameters),
        }

    @property
    def dataset(self) -> xarray.Dataset:
        """Readings and derivatives as an xarray Dataset with named columns."""
        data = self.readings.dataset
        dims = data["values"].dims
        found = {
            "by_start": ((*dims, "coordinate"), self.by_start, {"long_name": "derivatives by the initial state"}),
            "by_parameters": (
                (*dims, "parameter_name"),
                self.by_parameters,
                {"long_name": "derivatives by parameters"},
            ),
        }
        names = {"coordinate": list(self.coordinates), "parameter_name": list(self.parameters)}
        return data.assign(found).assign_coords(names)


@overload
def observed_partials(
    system: System,
    state: AnyState,
    observables: Observable | Readings,
    times: Times | None = ...,
    parameters: Sequence[str] = ...,
    *,
    formulation: str | None = ...,
    tolerance: float | None = ...,
    threads: int | None = ...,
    progress: bool | None = ...,
) -> ObservedPartials: ...


@overload
def observed_partials(
    system: System,
    state: AnyState,
    observables: Sequence[Observable | Readings],
    times: Times | None = ...,
    parameters: Sequence[str] = ...,
    *,
    formulation: str | None = ...,
    tolerance: float | None = ...,
    threads: int | None = ...,
    progress: bool | None = ...,
) -> tuple[ObservedPartials, ...]: ...


@checked
def observed_partials(
    system: System,
    state: AnyState,
    observables: Observable | Readings | Sequence[Observable | Readings],
    times: Times | None = None,
    parameters: Sequence[str] = (),
    *,
    formulation: str | None = None,
    tolerance: float | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> ObservedPartials | tuple[ObservedPartials, ...]:
    """Return readings with their exact partial derivatives by the initial state and by parameters.

    One integration of the variational equations serves all observables.

    Parameters
    ----------
    system, state, formulation, tolerance, threads, progress
        Same as in `state_transition`.
    observables : Observable, Readings or a list of these
        Instruments, or readings, whose times are used.
    times : array (n,), optional
        Times of the readings. Default: the times of the `Readings`.
    parameters : sequence of str
        Names of numbers of the system, its parts and orbits ("moments[0]", "forces[0].orbit.eccentricity") and of the
        observables ("gyro.bias[1]", "law.albedo"), or an unambiguous end of a name. The name of a vector without an
        index means all its components. A record that several forces and observables share is one parameter.

    Returns
    -------
    ObservedPartials or tuple of ObservedPartials
        Values and derivatives of one observable, or a tuple for a list of observables.

    Raises
    ------
    ValueError
        If a parameter does not exist, or belongs to an orbit that is integrated or tabulated.
    TypeError
        If a formula has no derivative.

    Examples
    --------
    >>> class Rate(pt.Observable):
    ...     bias: pt.BodyVector
    ...     components = ("x", "y", "z")
    ...     def reading(self, instant):
    ...         return instant.omega_body + self.bias
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    >>> found = pt.analysis.observed_partials(pt.System(body), start, Rate((0, 0, 0)), [0.0, 5.0], ["bias[1]"])
    >>> found.by_start.shape, found.by_parameters[..., 0].tolist()
    ((2, 3, 6), [[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    """
    given = list(observables) if isinstance(observables, Sequence) else [observables]
    plans = [_plan(each, times, system) for each in checked_observables(given)]
    chosen = NumberNames(system, [plan.observable for plan in plans]).chosen(parameters)
    settings = {"formulation": formulation, "tolerance": tolerance, "threads": threads, "progress": progress}
    found = _partials(system, state, plans, chosen, settings)
    return found if isinstance(observables, Sequence) else found[0]


def _plan(given: Observable | Readings, times: Times | None, system: System) -> Readings:
    """Return the readings to make: an observable with times."""
    if isinstance(given, Readings):
        if times is not None:
            raise ValueError("times must not be given for readings, which have times, got both. Leave them out.")
        return given
    if times is None:
        raise ValueError("times must be given for an observable, got none. Give times, or Readings(observable, times).")
    return Readings(given, checked_times(times, system), calendar=system.calendar)


def _partials(
    system: System, state: AnyState, plans: Sequence[Readings], chosen: _Chosen, settings: Mapping[str, Any]
) -> tuple[ObservedPartials, ...]:
    units, members = DerivedUnits(system.units), common_members(system, state)
    seen = []
    for plan in plans:
        refuse_unfit(system, plan.observable, members, plan.times)
        seen.append(plan.observable.time_of_body(plan.times, units))
    if members and any(each.ndim == 2 for each in seen):  # members are read at different times
        return _of_each_member(system, state, plans, chosen, settings, members[0])
    wanted = np.unique(np.concatenate([each.ravel() for each in seen]))
    transition = state_transition(system, state, wanted, chosen.of_system, **settings)
    return tuple(
        _of_one(transition, plan, number, at, chosen) for number, (plan, at) in enumerate(zip(plans, seen, strict=True))
    )


def _of_each_member(
    system: System,
    state: AnyState,
    plans: Sequence[Readings],
    chosen: _Chosen,
    settings: Mapping[str, Any],
    count: int,
) -> tuple[ObservedPartials, ...]:
    """Return the partial derivatives of members one by one."""
    each = []
    for i in range(count):
        some = [_of_member(plan, i) for plan in plans]
        own = members_of(state, i) if state.shape else state
        each.append(_partials(members_of(system, i), own, some, chosen, settings))
    return tuple(_stacked(plan, parts) for plan, *parts in zip(plans, *each, strict=True))


def _of_member(plan: Readings, member: int) -> Readings:
    """Return the plan of one member."""
    return plan.isel(member=member) if plan.is_ensemble else plan.of(members_of(plan.observable, member))


def _with_values(plan: Readings, values: Array, attributes: Mapping[str, str]) -> Readings:
    return Readings(
        plan.observable,
        plan.times,
        values,
        plan.sigma,
        name=plan.name,
        calendar=plan.calendar,
        attributes={**plan.attributes, **attributes},
    )


# ---------------------------------------------------------------------- names


class _Chosen(NamedTuple):
    """Parameters by name, with the numbers of the system and of each observable that they stand for.

    Attributes
    ----------
    names : tuple of str
        Full names.
    in_system : tuple of tuples of int
        Places among the numbers of the system, for each parameter; empty if the system does not have it.
    in_observables : tuple of tuples of (int, int)
        Observables by number, and places among their numbers, for each parameter.
    """

    names: tuple[str, ...]
    in_system: tuple[tuple[int, ...], ...]
    in_observables: tuple[tuple[tuple[int, int], ...], ...]

    @property
    def of_system(self) -> list[str]:
        """Names of the parameters that belong to the system."""
        return [name for name, places in zip(self.names, self.in_system, strict=True) if places]


class NumberNames:
    """Names of the numbers of a system and of observables; a shared number has the name that comes first."""

    def __init__(self, system: System, observables: Sequence[Observable]) -> None:
        self._system, self._observables = system, observables
        self._owned: dict[Own, str] = {}
        self._in_system: dict[str, list[int]] = {}
        self._in_observables: dict[str, list[tuple[int, int]]] = {}
        for place, (name, own) in enumerate(names_of_system(system.dynamics)):
            self._in_system.setdefault(self._owned.setdefault(own, name), []).append(place)
        for number, (start, observable) in enumerate(_by_name(observables)):
            for place, (name, own) in enumerate(names_of_numbers([(start, observable)])):
                self._in_observables.setdefault(self._owned.setdefault(own, name), []).append((number, place))

    def chosen(self, parameters: Sequence[str]) -> _Chosen:
        """Return the parameters that names stand for."""
        names = tuple(full for name in parameters for full in self._full(name))
        if doubled := [name for i, name in enumerate(names) if name in names[:i]]:
            raise ValueError(f"parameters must name each number once, got {quoted(doubled[0])} twice.")
        none: list[Any] = []
        return _Chosen(
            names,
            tuple(tuple(self._in_system.get(name, none)) for name in names),
            tuple(tuple(self._in_observables.get(name, none)) for name in names),
        )

    def owners(self, parameters: Sequence[str]) -> dict[str, Own]:
        """Return the identities of the numbers that names stand for, by their full names."""
        numbers = {name: own for own, name in self._owned.items()}
        return {name: numbers[name] for name in self.chosen(parameters).names}

    def name_of(self, own: Own) -> str | None:
        """Return the full name of a number; None if it is not one of these."""
        return self._owned.get(own)

    def _full(self, name: str) -> list[str]:
        """Return the full name of a number, or the names of the components of a vector."""
        known = list(dict.fromkeys(self._owned.values()))
        found = [each for each in known if each == name or each.endswith(f".{name}")]
        components = re.compile(rf"(?:.*\.)?{re.escape(str(name))}(?:\[\d+\])+")
        vectors = [each for each in known if components.fullmatch(each)]
        stems = {re.sub(r"(\[\d+\])+$", "", each) for each in vectors}
        if len(found) + len(stems) != 1:
            refuse_name_of_number(name, found + vectors[:3], known, "the system and the observables")
        full = found or vectors
        orbits = [*self._system.orbits, *(orbit for each in self._observables for orbit in orbits_of(each))]
        for own, each in self._owned.items():
            if each in full:
                refuse_integrated(orbits, own, name)
        return full


def _by_name(observables: Sequence[Observable]) -> list[tuple[str, Observable]]:
    """Return observables with their names; one that is there several times keeps its first name."""
    names = {id(each): name for name, each in observables_by_name(dict.fromkeys(observables)).items()}
    return [(names[id(each)], each) for each in observables]


# ---------------------------------------------------------------------- derivatives


class _Places(Environment):
    """Environment of a formula on nodes: orbits whose numbers or time vary by their formulas, others as numbers."""

    def __init__(self, time: Scalar, times: Array, known: Environment) -> None:
        super().__init__(time)
        self._times, self._known = times, known

    @override
    def position(self, orbit: Orbit) -> Vector:
        if not self._varies(orbit):
            return self._known.position(orbit)
        return _between_knots(orbit, self._times).position_at(self.time)

    @override
    def velocity(self, orbit: Orbit) -> Vector:
        if not self._varies(orbit):
            return self._known.velocity(orbit)
        return _between_knots(orbit, self._times).velocity_at(self.time)

    @override
    def inverse_distance(self, orbit: Orbit) -> Scalar:
        return 1 / functions.norm(self.position(orbit))

    @override
    def direction(self, orbit: Orbit) -> Vector:
        inverse = self.inverse_distance(orbit)
        return Vector(x * inverse for x in self.position(orbit))

    def _varies(self, orbit: Orbit) -> bool:
        return isinstance(self.time, Node) or any(isinstance(x, Node) for x in orbit.numbers)


def _between_knots(orbit: Orbit, times: Array) -> Orbit:
    """Return an orbit whose formulas accept nodes: of a table, the polynomial at each time."""
    if not orbit.knots.size:
        return orbit
    arc = orbit.between_knots(times)
    return arc.with_numbers(arc.numbers)


class _Traced(NamedTuple):
    """Numbers of a system and of an observable on which a formula is traced, some of them nodes."""

    dynamics: AnyDynamics
    observable: Observable
    inputs: list[dict[Node, GraphScalar]]


def _traced(graph: Graph, system: System, observable: Observable, number: int, chosen: _Chosen, axes: int) -> _Traced:
    """Return system and observable on numbers, with nodes in place of the chosen parameters."""
    own = [expanded(x, axes) for x in system.dynamics.numbers]
    read = [expanded(x, axes) for x in observable.numbers]
    nodes: list[list[Node]] = []
    varied: list[Any] = [*own]
    instrument: list[Any] = [*read]
    for places, others in zip(chosen.in_system, chosen.in_observables, strict=True):
        nodes.append([])
        for place in places:
            varied[place] = graph.variable(own[place])
            nodes[-1].append(varied[place])
        for which, place in others:
            if which == number:
                instrument[place] = graph.variable(read[place])
                nodes[-1].append(instrument[place])
    inputs = [dict.fromkeys(each, 1.0) for each in nodes]
    return _Traced(system.dynamics.with_numbers(varied), observable.with_numbers(instrument), inputs)  # type: ignore[arg-type]


def _of_one(transition: StateTransition, plan: Readings, number: int, seen: Array, chosen: _Chosen) -> ObservedPartials:
    """Return the readings of one observable, with derivatives, from the state transition at the times of the body."""
    motion, observable, system = transition.motion, plan.observable, transition.motion.system
    if seen.ndim == 2:  # one body, read by members at different times
        some = [_of_member(plan, i) for i in range(len(seen))]
        parts = [_of_one(transition, each, number, at, chosen) for each, at in zip(some, seen, strict=True)]
        return _stacked(plan, parts)
    wanted, back = np.unique(seen, return_inverse=True)
    at = np.searchsorted(motion.times, wanted)
    found = _derivatives(motion.isel(time=at), transition.coordinates, observable, number, chosen)
    rows: Any = (..., at, slice(None), slice(None))
    Phi, S = (matrix[rows] for matrix in (transition.matrix, transition.sensitivity))
    if observable.components:
        Phi, S = Phi[..., None, :, :], S[..., None, :, :]
    by_start = (found.by_state[..., None, :] @ Phi)[..., 0, :]
    by_parameters = np.array(found.by_parameters)
    through = [i for i, each in enumerate(chosen.in_system) if each]
    by_parameters[..., through] += (found.by_state[..., None, :] @ S)[..., 0, :]
    axis = found.values.ndim - 1 - bool(observable.components)
    arrays = [np.take(x, back, axis) for x in (found.values, by_start, by_parameters)]
    hidden = hidden_readings(observable, plan.times, arrays[0].shape[: axis + 1])
    for where in hidden.values():
        for array in arrays:
            array[where] = np.nan
    values, by_start, by_parameters = arrays
    absent = {name: np.take(where, back, axis) for name, where in found.absent.items()}
    both = [ReadingsOfMembers(values, absent), ReadingsOfMembers(np.empty(0), hidden)]
    warn_of_absent(observable, absent_counts(observable, both))
    about = {"units": observable.unit(DerivedUnits(system.units)), "frame": observable.frame}
    about |= {"time_units": system.units["time"], "system": repr(system), "initial_state": repr(motion.initial)}
    readings = _with_values(plan, values, {name: text for name, text in about.items() if text})
    return ObservedPartials(readings, transition.coordinates, chosen.names, by_start, by_parameters)


def _stacked(plan: Readings, parts: Sequence[ObservedPartials]) -> ObservedPartials:
    """Return the partial derivatives of members together."""
    values, by_start, by_parameters = (
        np.stack([getattr(part, name) for part in parts]) for name in ("values", "by_start", "by_parameters")
    )
    readings = _with_values(plan, values, parts[0].readings.attributes)
    return ObservedPartials(readings, parts[0].coordinates, parts[0].parameters, by_start, by_parameters)


class _Derivatives(NamedTuple):
    """Readings, and their derivatives by the state at the times of the body and, explicitly, by parameters.

    The arrays have the shapes (..., [components]), (..., [components], k) and (..., [components], p). `absent` is True
    where there is no reading, by reason.
    """

    values: Array
    by_state: Array
    by_parameters: Array
    absent: dict[str, NDArray[np.bool_]]


def _derivatives(
    motion: Trajectory, coordinates: Sequence[str], observable: Observable, number: int, chosen: _Chosen
) -> _Derivatives:
    """Return the readings of all rows of a motion, with derivatives."""
    system, state, times, graph = motion.system, motion._reader.state, motion.times, Graph()
    if observable.member_axis and not motion.is_ensemble:
        state = state_of(changed(state.phase, lambda x: x[None]), state.time)
    shape = np.broadcast_shapes(state.shape, observable.member_axis + (1,) * bool(observable.member_axis))
    traced = _traced(graph, system, observable, number, chosen, len(shape))
    delays = _delays(observable, number, chosen, times, system)
    moment: Scalar = graph.variable(times) if delays else times
    bodies = [_turning(graph, each) for each in state.of_bodies.values()]
    own = {name: Vector(map(graph.variable, scalars(values))) for name, values in state.own.items()}
    attitudes = [
        (Attitude(cast("Any", body.matrix), quaternion=body.quaternion), Vector(body.momentum)) for body in bodies
    ]
    environment = _Places(moment, times, motion.environment)
    reading = traced.observable.reading(cast("Instant", traced.dynamics.instant(attitudes, own, environment)))
    outputs = list(reading) if observable.components else [reading]
    full, variables = coordinate_names(system), [x for values in own.values() for x in values]
    space = TangentSpace([full.index(name) for name in coordinates], bodies, variables)
    seeds = [*(space.vector(unit, {}).seeds for unit in np.eye(len(coordinates)).tolist()), *traced.inputs]
    if delays:
        velocity = [graph.leaf(x) for x in _velocity(system, state, motion)]
        drift = TangentSpace(range(len(full)), bodies, variables).vector(velocity, {})
        seeds.append(drift.seeds | {cast("Node", moment): 1.0})
    columns = _differentials(outputs, seeds)
    if delays:
        along = columns.pop()
        for place, delay in delays.items():
            column = columns[len(coordinates) + place]
            columns[len(coordinates) + place] = [
                x + graph.leaf(delay) * rate for x, rate in zip(column, along, strict=True)
            ]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        numbers = graph.finished([*outputs, *(x for column in columns for x in column)])
    table = np.stack([np.broadcast_to(np.asarray(x, dtype=float), shape) for x in numbers], axis=-1)
    table = np.swapaxes(table.reshape(*shape, 1 + len(columns), len(outputs)), -1, -2)
    expanded_observable = observable.with_numbers(expanded(x, len(shape)) for x in observable.numbers)
    absent = absent_readings(expanded_observable, system.at(state, motion.environment), table[..., 0])
    table[np.logical_or.reduce([*absent.values(), np.zeros(shape, dtype=bool)])] = np.nan
    table = table if observable.components else table[..., 0, :]
    k = len(coordinates)
    return _Derivatives(table[..., 0], table[..., 1 : k + 1], table[..., k + 1 :], absent)


def _differentials(outputs: Sequence[Scalar], seeds: Sequence[Mapping[Node, GraphScalar]]) -> list[list[Any]]:
    """Return the differentials of outputs for several sets of differentials of nodes, from one gradient of each output.

    Readings have few components and many columns of derivatives, so that gradients cost less than tangents.
    """
    nodes = list(dict.fromkeys(node for each in seeds for node in each))
    slopes = [dict(zip(nodes, gradient(output, nodes), strict=True)) for output in outputs]
    return [[sum(slope[node] * seed for node, seed in each.items()) for slope in slopes] for each in seeds]


def _turning(graph: Graph, state: State) -> TurningBody:
    """Return attitude and momentum of a body as nodes."""
    q = scalars(state.quaternion)
    matrix = Attitude.from_quaternion(q).matrix
    nodes = matrix_of([graph.variable(x) for x in row] for row in matrix)
    quaternion, momentum = (Vector(map(graph.variable, x)) for x in (q, scalars(state.angular_momentum_body)))
    return TurningBody(cast("Any", nodes), quaternion, momentum)


def _velocity(system: System, state: AnyState, motion: Trajectory) -> list[Scalar]:
    """Return the velocity of a motion as a tangent vector, all coordinates."""
    dynamics = system.dynamics.broadcast_to(state.shape)
    turnings, blocks = dynamics.changes(dynamics.at(state, motion.environment))
    rigid = [x for each in turnings for x in (*each.omega, *each.momentum_rate)]
    return [*rigid, *(x for name in state.own for x in blocks[name])]


def _delays(observable: Observable, number: int, chosen: _Chosen, times: Array, system: System) -> dict[int, Array]:
    """Return the derivatives of the time of the body by parameters of the light path, by the places of the parameters.

    From te + |r(te)| / c = t follows d te / d p = - (d |r| / d p) / (c + d |r| / d te).
    """
    if observable.light_path is None:
        return {}
    graph = Graph()
    axes = 1 + len(observable.member_axis)
    time = graph.variable(times)
    traced = _traced(graph, system, observable, number, chosen, axes)
    path = cast("Orbit", traced.observable.light_path)
    varied = {x for x in path.numbers if isinstance(x, Node)}
    places = [place for place, inputs in enumerate(traced.inputs) if varied & inputs.keys()]
    if not places:
        return {}
    distance = functions.norm(_between_knots(path, times).position_at(time))
    slopes = [tangents([distance], {time: 1.0}), *(tangents([distance], traced.inputs[place]) for place in places)]
    speed, *by_numbers = graph.finished([x for each in slopes for x in each])
    light = speed_of_light(DerivedUnits(system.units))
    return {place: -np.asarray(x) / (light + speed) for place, x in zip(places, by_numbers, strict=True)}
