"""Sizes of momenta and of other variables along a motion, which the integrated variables are scaled by."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from poinsot import functions
from poinsot.functions import Scalar, Vector
from poinsot.kinematics.attitude import Attitude
from poinsot.kinematics.state import AnyState, State, changed
from poinsot.mechanics.environment import Environment, orbits_of, sample_time
from poinsot.mechanics.force import Force, Potential, Torque, derived_torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.two_bodies import TwoBodies, mean_motion
from poinsot.quantities import Array
from poinsot.systems.body_dynamics import BodyDynamics
from poinsot.systems.branch_exploration import BRANCH_SAMPLES, conditions, on_branches
from poinsot.systems.dynamics import AnyDynamics, Dynamics
from poinsot.systems.formula_trials import ATTITUDES, RATES
from poinsot.systems.pair_dynamics import ORBIT
from poinsot.systems.probing import sample_times, samples, time_scales
from poinsot.systems.system import System
from poinsot.taylor.graph import Evaluator, Graph, GraphScalar

__all__ = [
    "fastest_rates",
    "momentum_ratios",
    "momentum_scale",
    "momentum_scale_of_members",
    "momentum_scales",
    "orbital_rate",
    "power_of_two",
    "sample_torque",
    "sizes_of_blocks",
    "torque_scale",
    "traced_sizes",
]

Number = float | Array

MIN_SCALE, MAX_SCALE = 2.0**-512, 2.0**512
"""Limits of a momentum scale: squares of smaller scales underflow to zero, and squares of larger scales overflow."""

MAX_PART_AT_REST = 1e-9
"""Part of the rate of a variable with a momentum below which the part counts as resting: the rate is then rounding."""


def momentum_scale(system: AnyDynamics, state: AnyState) -> Number:
    """Return the approximate size of the angular momentum along the motion from a state; shape (...).

    The size for one body is the larger of |g| and the momentum that the forces would give a body at rest, or 1 if both
    are zero. The size for two bodies refers to the primary.
    """
    return next(iter(momentum_scales(system, state, torque_scale(system)).values()))


def momentum_scale_of_members(system: BodyDynamics, state: State) -> Number:
    """Return the momentum scale of a single body, with torques at the same samples as for members of an ensemble."""
    results = system.results
    if "momentum at samples" not in results:
        results["momentum at samples"] = _momentum_of(system, _strongest_at_samples(system, _has_branches(system)))
    return _momentum_scale(system, state, results["momentum at samples"])


def fastest_rates(system: System, state: AnyState) -> Array:
    """Return the rate of the fastest angle along the motion from a state: of the orbit, or else of the body."""
    dynamics: AnyDynamics = system.dynamics
    if not isinstance(dynamics, BodyDynamics):
        return np.asarray(orbital_rate(dynamics, state))
    scale = momentum_scale_of_members(dynamics, state.of_bodies[""])
    own = np.asarray(scale / np.min(dynamics.body.moments, axis=-1))
    if not system.orbits:
        return own
    paths = [orbit.with_axes(1) for orbit in system.orbits]
    each = [functions.norm(path.velocity_at(path.sample_time)) > 0 for path in paths]
    moving, rates = np.asarray(functools.reduce(np.logical_or, each, False)), 1 / time_scales(dynamics)
    return np.where(moving, rates, own) if moving.ndim or not moving else rates


def momentum_scales(system: AnyDynamics, state: AnyState, torque: Number) -> dict[str, Number]:
    """Return the approximate sizes of the angular momenta along the motion from a state, by the name of the body.

    `torque` is the angular momentum that corresponds to the torques, see `torque_scale`.
    The size for one of two bodies is the larger of |g| and the momentum of a body that rotates with the orbit.
    """
    if isinstance(system, BodyDynamics):
        return {"": _momentum_scale(system, state.of_bodies[""], torque)}
    rate = orbital_rate(system, state)
    moments = [np.max(np.asarray(body.moments), axis=-1) for body in system.of_bodies.values()]
    return {
        name: np.maximum(np.linalg.norm(each.angular_momentum_body, axis=-1), largest * rate)
        for (name, each), largest in zip(state.of_bodies.items(), moments, strict=True)
    }


def momentum_ratios(sizes: Mapping[str, Number]) -> dict[str, Number]:
    """Return the powers of two that scale the angular momenta of bodies to the size of the first body's."""
    first, *others = sizes
    return {first: 1.0, **{name: power_of_two(sizes[first] / sizes[name]) for name in others}}


def power_of_two(ratio: Number) -> Number:
    """Return the power of two nearest to a ratio, or to the ratios of members: it scales without rounding."""
    if isinstance(ratio, np.ndarray) or not 0 < ratio < math.inf:
        nearest: Array = np.exp2(np.rint(np.log2(ratio)))
        return nearest
    return math.ldexp(1.0, round(math.log2(ratio)))


def _momentum_scale(system: BodyDynamics, state: State, largest: Number) -> Number:
    each = [state.angular_momentum_body]
    for part in system.parts:
        each += [state.own[part.name][..., place] for place in part.momentum_places]
    largest = _largest(largest, *map(_length, each))
    if isinstance(largest, np.ndarray):
        scales: Array = np.minimum(largest + (largest < MIN_SCALE), MAX_SCALE)
        return scales
    return min(largest + (largest < MIN_SCALE), MAX_SCALE)


def orbital_rate(system: Dynamics[TwoBodies, Any], state: AnyState) -> Number:
    """Return the mean motion of a circular orbit of two bodies at the distance of a state; shape (...)."""
    rate: Number = mean_motion(system.body, np.linalg.norm(state.own[ORBIT.name][..., :3], axis=-1))
    return rate


# ---------------------------------------------------------------------- torques


def torque_scale(system: AnyDynamics) -> Number:
    """Return the angular momentum that corresponds to the torques at samples; shape () or (members,).

    The momentum is sqrt(I N) with the largest moment of inertia I and the torque N on a body at rest. Zero for two
    bodies, whose momenta are scaled by the orbital rate.
    """
    if not isinstance(system, BodyDynamics):
        return np.zeros(system.members) if system.members else 0.0
    if "torque scale" not in system.results:
        branching = _has_branches(system)
        one = not branching and not system.members
        torque = sample_torque(system) if one else _strongest_at_samples(system, branching)
        momentum = _momentum_of(system, torque)
        system.results["torque scale"] = np.broadcast_to(momentum, system.members) if system.members else momentum
    scale: Number = system.results["torque scale"]
    return scale


def _momentum_of(system: BodyDynamics, torque: Number) -> Number:
    moments = system.body.moments
    momentum: Number = np.sqrt(_largest(*(moments.tolist() if moments.ndim == 1 else moments.T)) * torque)
    return momentum


def _strongest_at_samples(system: BodyDynamics, branching: bool) -> Number:
    with np.errstate(all="ignore"):
        graph, sizes = system.results.pop("traced sizes", None) or traced_sizes(system)
        found = [graph.evaluated(sizes), *[on_branches(graph, sizes)] * branching]
        return functools.reduce(np.maximum, (_summed(system.forces, each) for each in found))


def _summed(forces: Sequence[Force], sizes: Sequence[Number]) -> Number:
    """Return the sum over the forces of the largest torque, or of the range of the energy, of each member."""
    ranges = (
        np.max(size, axis=-1) - (np.min(size, axis=-1) if isinstance(force, Potential) else 0.0)
        for force, size in zip(forces, map(np.atleast_1d, sizes), strict=True)
    )
    total: Number = sum(np.nan_to_num(each, posinf=0.0) for each in ranges)
    return total


def traced_sizes(system: BodyDynamics) -> tuple[Graph, list[Any]]:
    """Return the graph and the sizes of energies or torques on a body at rest at samples, one for each force."""
    (q, _, _), t = samples(system, BRANCH_SAMPLES), sample_times(system, BRANCH_SAMPLES)
    graph, twin, at_rest = Graph(), system.broadcast_to((*system.members, BRANCH_SAMPLES)), Vector((0.0, 0.0, 0.0))
    time = graph.variable(t)
    body = twin.body_at({part.name: part.start(time, at_rest) for part in twin.parts}, time)
    instant = Instant(body, Attitude.from_quaternion(Vector(q.T)), Environment(time), at_rest)
    with np.errstate(all="ignore"):
        return graph, [_size(force, instant) for force in twin.forces]


def _size(force: Force, instant: Instant) -> Any:
    if isinstance(force, Potential):
        return force.energy(instant)
    return functions.norm(force.torque(instant)) if isinstance(force, Torque) else 0.0


def _has_branches(system: BodyDynamics) -> bool:
    """Return True if the formula of a force has a condition on the time or on an orbit."""
    if "has branches" not in system.alike:
        traced = traced_sizes(system)
        system.alike["has branches"] = bool(conditions(traced[1]))
        if not system.members:  # the graph of an ensemble is large
            system.results["traced sizes"] = traced
    found: bool = system.alike["has branches"]
    return found


def sample_torque(system: BodyDynamics) -> float:
    """Return the sum of the torques of the forces on the first member's body at rest at a sample.

    The difference of the energies at two samples replaces the torque of a potential if the difference is larger.
    """
    first = [number.item(0) for number in system.numbers]
    times = [(sample_time(orbits_of(force)) if system.orbits else 0.0) + 0.25 for force in system.forces]
    if "traced samples" not in system.alike:
        system.alike["traced samples"] = _traced_samples(system)
    traced = system.alike["traced samples"]
    with np.errstate(all="ignore"):
        found = traced([*first, *times]) if traced else [*_samples(system.with_numbers(map(np.float64, first)), times)]
        values = iter([*map(float, cast("Iterable[float]", found))])
    return math.fsum([_larger(*sample) for sample in zip(*[values] * 5, strict=True)])


def _larger(*sample: float) -> float:
    *torque, here, there = sample
    return max(filter(math.isfinite, (math.hypot(*torque), abs(there - here))), default=0.0)


def _traced_samples(system: BodyDynamics) -> Evaluator | None:
    """Return the evaluator of the samples for all numbers of a structure, or None if formulas reject symbols."""
    graph = Graph()
    inputs = [graph.input(place) for place in range(len(system.numbers) + len(system.forces))]
    twin = system.with_numbers(inputs)
    try:
        traced = cast("list[GraphScalar]", [*_samples(twin, inputs[len(system.numbers) :])])
        return Evaluator(traced, np.float64)
    except Exception:  # such as an error from a table, which is read at a time
        return None


def _samples(system: BodyDynamics, times: Sequence[Scalar]) -> Iterator[Scalar]:
    """Yield the torque of each force on the body at rest, and its energies at two samples."""
    bodies = [system.body_in_rotation(0.25, Vector(omega)) for omega in RATES.T.tolist()]
    attitudes = [Attitude.from_quaternion(q) for q in ATTITUDES.tolist()]
    for force, time in zip(system.forces, times, strict=True):
        environment = Environment(time)
        if isinstance(force, Potential):
            here, there = map(Instant, bodies, attitudes, (environment, environment))
            yield from (*derived_torque(force, here), force.energy(here), force.energy(there))
        elif isinstance(force, Torque):
            yield from (*force.torque(Instant(bodies[0], attitudes[0], environment, RATES.T[0].tolist())), 0.0, 0.0)
        else:
            yield from (0.0,) * 5


# ---------------------------------------------------------------------- variables of parts and of the relative orbit


def sizes_of_blocks(system: AnyDynamics, state: AnyState) -> dict[str, NDArray[np.float64]]:
    """Return the sizes of the variables of parts or of the relative orbit, by the name of the block; each (..., k).

    The size of a variable of a part is the larger of its value and its change while the body rotates by a radian. The
    size for a part at rest is the change of a part without momentum in a body that rotates as fast about any axis. The
    result omits parts whose variables are all angular momenta.
    """
    if not isinstance(system, BodyDynamics):
        return {ORBIT.name: _sizes_of_orbit(system, state)}
    state = state.of_bodies[""]
    names = [part.name for part in system.parts if part.momenta < set(part.variables)]
    if not names:
        return {}
    twin, g = system.broadcast_to(state.shape), np.linalg.norm(state.angular_momentum_body, axis=-1)
    without = {"quaternion": state.quaternion, **changed(state.own, np.zeros_like)}
    turning = [
        State.computed(without | {"angular_momentum_body": g[..., None] * axis}, state.time) for axis in np.eye(3)
    ]
    with np.errstate(all="ignore"):
        speed = np.asarray(system.speed(state))[..., None]
        fastest = np.where(speed > 0, speed, 1.0)
        each = [twin.block_rates(twin.at(start)) for start in (state, *turning)]
    sizes = {}
    for name in names:
        here, *there = (np.abs(np.stack(np.broadcast_arrays(*rates[name]), axis=-1)) for rates in each)
        farthest = np.max(there, axis=0)
        changes = np.where(here > MAX_PART_AT_REST * farthest, here, farthest) / fastest
        sizes[name] = np.maximum(np.abs(state.own[name]), changes)
    return sizes


def _sizes_of_orbit(system: Dynamics[TwoBodies, Any], state: AnyState) -> NDArray[np.float64]:
    position, momentum = np.split(state.own[ORBIT.name], 2, axis=-1)
    distance, mass = np.linalg.norm(position, axis=-1), system.body.reduced_mass
    momentum = np.maximum(np.linalg.norm(momentum, axis=-1), mass * distance * orbital_rate(system, state))
    return np.stack([distance] * 3 + [np.broadcast_to(momentum, distance.shape)] * 3, axis=-1)


# ---------------------------------------------------------------------- numbers, or arrays of the numbers of members


def _largest(*numbers: Number) -> Number:
    """Return the largest number, or the numbers of members. NumPy takes a microsecond for three numbers."""
    return functools.reduce(np.maximum, numbers) if np.ndarray in map(type, numbers) else max(numbers)


def _length(vector: Array) -> Number:
    """Return the length of a vector, or of the vectors of members."""
    if vector.ndim == 1:
        return math.hypot(*vector.tolist())
    length: Array = functools.reduce(np.hypot, vector.T, np.zeros(()))
    return length
