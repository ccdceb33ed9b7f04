"""Relative equilibria of two bodies at given distances, with their small oscillations and stability.

In axes that turn at a constant rate Omega both bodies rest, except for spins sigma about axes of symmetry. The axes of
reference of a body do not follow its spin. The vector x, (theta, gamma) of the primary and of the secondary and the
changes of position and momentum, obeys x' = matrix x to first order. The total angular momentum removes three of its 18
dimensions, the turn about it one, and each spin two.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.analysis.equilibrium import HALF_TURNS, grows_with_time
from poinsot.analysis.pair_point import PairPoint, cross_matrix, refuse_open, symmetry_axis, units_of_pair
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.errors import real_array, refuse_nonpositive
from poinsot.functions import Vector, cross
from poinsot.immutable import cached_property
from poinsot.kinematics.attitude import Attitude, rotation_matrix
from poinsot.kinematics.state import PairState
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.pair_instant import PairInstant
from poinsot.mechanics.two_bodies import TwoBodies
from poinsot.printable import quoted
from poinsot.records.units import DerivedUnits
from poinsot.systems.system import OfTwoBodies, System
from poinsot.taylor.graph import Graph, Node, gradient

__all__ = ["PairEquilibrium", "pair_equilibria"]

Array = NDArray[Any]

RATE_TOLERANCE = 1e-6
"""Size of rates that count as zero, relative to the rate of the axes; its square for curvatures of the energy."""
EIGENVALUE_ROUNDING = 1e-11
"""Rounding error of eigenvalues, relative to the largest one."""
BALANCE_TOLERANCE = 1e-12
"""Largest residual of a balance, relative to the sizes of forces and torques."""
NEUTRAL_TOLERANCE = 1e-9
"""Relative size of singular values in whose direction the balance does not change."""
MAX_ITERATIONS = 50
MAX_STEP = 0.3
"""Largest step of Newton's method, radians, and of the rate, relative to it."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PairEquilibrium(Summarized):
    """Relative equilibrium: two bodies at rest in uniformly rotating axes; radians, the user's units.

    Attributes
    ----------
    system : System
        The two bodies with their forces.
    state : PairState
        State at rest in the rotating axes.
    rate : array (3,)
        Angular velocity of the axes, space axes.
    matrix : array (18, 18)
        Matrix of the linear equations x' = matrix x, x = (rotation vector and change of angular momentum of the primary
        along its axes, rotation vector and change of angular momentum of the secondary along its axes, changes of
        position and momentum along the rotating axes).
    eigenvalues : complex array
        Eigenvalues of motions with the same angular momentum, without rotations about it and without spins about axes
        of symmetry: 14, less two for each axis of symmetry.
    frequencies, growth_rates : arrays, ascending
        Positive imaginary and real parts of the eigenvalues, without parts below 1e-6 of the rate.
    stability : {"lyapunov", "linear", "unstable", "undecided"}
        "lyapunov": the energy has a minimum among the motions with the same angular momentum. "linear": no solution of
        the linear equations grows, but the energy proves nothing. "unstable": a solution grows. "undecided": a
        stiffness vanishes.

    Examples
    --------
    >>> body = pt.Body.from_ellipsoid(1.0, (1.2, 1.0, 0.9))
    >>> pair = pt.TwoBodies(body, body, G=1.0)
    >>> system = pt.System(pair, pt.forces.MutualGravity())
    >>> guess = pair.doubly_synchronous(distance=9.0)
    >>> far, near = pt.analysis.pair_equilibria(system, guess, distances=[9.0, 2.42])
    >>> far.stability, near.stability, far.frequencies.size
    ('lyapunov', 'unstable', 7)
    """

    system: System[TwoBodies]
    state: PairState
    rate: Array
    matrix: Array
    eigenvalues: Array
    frequencies: Array
    growth_rates: Array
    stability: str

    @property
    def distance(self) -> float:
        """Distance of the centres of mass."""
        return float(np.linalg.norm(self.state.position))

    @checked
    def displaced(self, number: int, amplitude: float) -> PairState:
        """Return the state displaced along a small oscillation, as a guess for `periodic_motion`.

        Parameters
        ----------
        number : int
            Index of the oscillation in `frequencies`.
        amplitude : float
            Amplitude of the largest component, which is at its maximum: radians of a rotation vector along the axes of
            a body, or a fraction of the distance.

        Raises
        ------
        ValueError
            If the index is out of range, or the amplitude is larger than half a turn.

        Examples
        --------
        >>> body = pt.Body.from_ellipsoid(1.0, (1.2, 1.0, 0.9))
        >>> pair = pt.TwoBodies(body, body, G=1.0)
        >>> system = pt.System(pair, pt.forces.MutualGravity())
        >>> (rest,) = pt.analysis.pair_equilibria(system, pair.doubly_synchronous(distance=9.0))
        >>> guess, period = rest.displaced(-1, 0.01), 2 * np.pi / rest.frequencies[-1]
        >>> pt.analysis.periodic_motion(system, guess, period).stable
        True
        """
        amplitude, number = float(real_array("amplitude", amplitude, ())), int(real_array("number", number, ()))
        if number not in range(-(count := len(self.frequencies)), count):
            raise ValueError(f"number must be a whole number from {-count} to {count - 1}, got {number}.")
        if abs(amplitude) > np.pi:
            raise ValueError(
                f"amplitude must be at most pi in size, got {quoted(amplitude)}. Linear equations hold for small ones."
            )
        point, rate_of_axes = PairPoint.of(self.state), float(np.linalg.norm(self.rate))
        units = units_of_pair(self.system, self.distance, rate_of_axes)
        axes = [symmetry_axis(body) for body in self.system.of_bodies.values()]
        basis = point.free(self.rate / rate_of_axes, axes, units)
        eigenvalues, modes = np.linalg.eig(basis.T @ (self.matrix * units / units[:, None]) @ basis)
        mode = basis @ modes[:, np.argmin(np.abs(eigenvalues - 1j * self.frequencies[number]))]
        places = mode.reshape(3, 2, 3)[:, 0].ravel()
        x = (mode * (amplitude / places[np.argmax(np.abs(places))])).real * units
        return point.displaced(x).state(self.state.time)

    @property
    def stable(self) -> bool:
        """True if the stability is "lyapunov" or "linear"."""
        return self.stability in ("lyapunov", "linear")

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        units = DerivedUnits(self.system.units)
        return f"Equilibrium of two bodies: {self.stability}", {
            "distance": formatted(self.distance, units.length),
            "rate": formatted(np.linalg.norm(self.rate), units.rate_in_words),
            "frequencies": formatted(self.frequencies, units.rate_in_words),
            "growth rates": formatted(self.growth_rates, units.per_time),
        }


@checked
def pair_equilibria(
    system: OfTwoBodies, guess: PairState, *, distances: ArrayLike | None = None
) -> list[PairEquilibrium]:
    """Return the relative equilibria of two bodies near a guess, at given distances of the centres of mass.

    Newton's method varies both attitudes and the angular velocity. The iteration for each distance begins at the
    previous equilibrium. A body with an axis of symmetry retains its spin about this axis from the guess; any other
    body rotates with the line of centres.

    Parameters
    ----------
    system : System
        System of two bodies, not an ensemble, with potentials that conserve energy and angular momentum.
    guess : PairState
        Initial guess, such as `pair.doubly_synchronous(distance=...)`, or `pair.synchronous(...)` with a symmetric
        primary.
    distances : array (n,), optional
        Distances of the centres of mass. Default: the distance of the guess.

    Returns
    -------
    list of PairEquilibrium
        One equilibrium for each distance.

    Raises
    ------
    ValueError
        If the system is not of this kind, or no equilibrium is near the guess.

    Examples
    --------
    >>> primary, moon = pt.Body.from_ellipsoid(1.0, (1, 1, 0.8)), pt.Body.from_ellipsoid(1e-9, (0.14, 0.1, 0.09))
    >>> pair = pt.TwoBodies(primary, moon, G=1.0)
    >>> guess = pair.synchronous(distance=50.0, primary_rate=1.0)
    >>> (found,) = pt.analysis.pair_equilibria(pt.System(pair, pt.forces.MutualGravity()), guess)
    >>> (found.frequencies / np.linalg.norm(found.rate))[:3].round(3)  # the second: sqrt(3 (0.96 / 2.96))
    array([0.281, 0.986, 1.   ])
    """
    refuse_open(system, guess)
    place = np.linalg.norm(guess.position)
    lengths = np.atleast_1d(real_array("distances", [place] if distances is None else distances, (None,)))
    refuse_nonpositive("distances", lengths)
    found, here = [], _PairBalance.of(system, guess)
    for length in lengths:
        here = here.at_distance(float(length)).settled()
        found.append(here.equilibrium(guess.time))
    return found


@dataclasses.dataclass(frozen=True, eq=False)
class _PairBalance:
    """Balance of torques and forces of two bodies that are nearly at rest in rotating axes.

    Attributes
    ----------
    attitudes : array (2, 4)
    position, rate : array (3,)
        Position of the secondary and angular velocity of the axes, space axes.
    axes : two of array (3,) or None
        Axes of symmetry, along the body axes.
    spins : two of float
        Inertial angular velocities about the axes of symmetry.
    """

    flow: _Flow
    attitudes: Array
    position: Array
    rate: Array
    axes: tuple[Array | None, ...]
    spins: tuple[float, ...]

    @classmethod
    def of(cls, system: System[TwoBodies], guess: PairState) -> _PairBalance:
        flow, states = _Flow(system), list(guess.of_bodies.values())
        attitudes = np.array([state.quaternion for state in states])
        position, velocity = guess.position, guess.momentum / float(system.body.reduced_mass)
        rate = np.cross(position, velocity) / (position @ position)
        axes = tuple(map(symmetry_axis, flow.bodies))
        omegas = [body.omega(s.angular_momentum_body) for body, s in zip(flow.bodies, states, strict=True)]
        spins = tuple(0.0 if axis is None else float(w @ axis) for w, axis in zip(omegas, axes, strict=True))
        return cls(flow, attitudes, position, rate, axes, spins)

    def at_distance(self, distance: float) -> _PairBalance:
        """Return the balance at another distance, with the rate of Kepler's third law."""
        ratio = distance / float(np.linalg.norm(self.position))
        return dataclasses.replace(self, position=ratio * self.position, rate=self.rate * ratio**-1.5)

    # ------------------------------------------------------------------ equations

    @cached_property
    def matrices(self) -> Array:
        return rotation_matrix(self.attitudes)

    @cached_property
    def omegas(self) -> list[Array]:
        """Inertial angular velocities of the bodies, along their axes."""
        out = []
        for matrix, axis, spin in zip(self.matrices, self.axes, self.spins, strict=True):
            omega = matrix.T @ self.rate
            out.append(omega if axis is None else omega + (spin - axis @ omega) * axis)
        return out

    @cached_property
    def momenta(self) -> list[Array]:
        return [body.angular_momentum(omega) for body, omega in zip(self.flow.bodies, self.omegas, strict=True)]

    @cached_property
    def momentum(self) -> Array:
        """Momentum of the orbit."""
        return self.flow.mass * np.cross(self.rate, self.position)

    @cached_property
    def units(self) -> Array:
        """Sizes of the 18 coordinates."""
        distance, rate_of_axes = (float(np.linalg.norm(vector)) for vector in (self.position, self.rate))
        return units_of_pair(self.flow.system, distance, rate_of_axes)

    @cached_property
    def _rates_and_matrix(self) -> tuple[Array, Array]:
        """Rates of the 18 coordinates in the rotating axes, and their derivatives by the coordinates."""
        values = [*self.attitudes[0], *self.momenta[0], *self.attitudes[1], *self.momenta[1]]
        rates, slopes = self.flow.evaluated([*values, *self.position, *self.momentum, *self.rate])
        for i, (axis, matrix, g) in enumerate(zip(self.axes, self.matrices, self.momenta, strict=True)):
            if axis is None:
                continue
            spin = self.spins[i] - axis @ matrix.T @ self.rate
            rates[6 * i : 6 * i + 3] -= spin * axis
            rates[6 * i + 3 : 6 * i + 6] -= spin * np.cross(g, axis)
            slopes[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] += spin * cross_matrix(axis)
        return rates, slopes

    def _imbalance(self) -> tuple[Array, Array]:
        """Return the unbalanced torques and force, (9,), and their derivatives by both turns and the rate, (9, 9)."""
        rates, matrix = self._rates_and_matrix
        unknown = np.zeros((18, 9))
        for i, (axis, turn, body) in enumerate(zip(self.axes, self.matrices, self.flow.bodies, strict=True)):
            rate = turn.T @ self.rate
            by_turn, by_rate = cross_matrix(rate), turn.T
            if axis is not None:
                across = np.eye(3) - np.outer(axis, axis)
                by_turn, by_rate = across @ by_turn, across @ by_rate
            unknown[6 * i : 6 * i + 3, 3 * i : 3 * i + 3] = np.eye(3)
            unknown[6 * i + 3 : 6 * i + 6, 3 * i : 3 * i + 3] = body.inertia @ by_turn
            unknown[6 * i + 3 : 6 * i + 6, 6:] = body.inertia @ by_rate
        unknown[15:, 6:] = -self.flow.mass * cross_matrix(self.position)
        slope = matrix @ unknown
        slope[15:, 6:] += cross_matrix(self.momentum)  # derivative of -Omega x p by Omega
        for i, (axis, turn, g) in enumerate(zip(self.axes, self.matrices, self.momenta, strict=True)):
            if axis is not None:  # spin relative to the rotating axes
                change = np.cross(g, axis)
                slope[6 * i + 3 : 6 * i + 6, 6:] += np.outer(change, axis @ turn.T)
                slope[6 * i + 3 : 6 * i + 6, 3 * i : 3 * i + 3] += np.outer(
                    change, axis @ cross_matrix(turn.T @ self.rate)
                )
        places = [3, 4, 5, 9, 10, 11, 15, 16, 17]
        return rates[places], slope[places]

    def settled(self) -> _PairBalance:
        """Return the equilibrium to which Newton's method converges."""
        here = self
        for _ in range(MAX_ITERATIONS):
            force, slope = here._imbalance()
            rate_of_axes = np.linalg.norm(here.rate)
            rows = here.units[[3, 4, 5, 9, 10, 11, 15, 16, 17]] * rate_of_axes
            columns = np.array([1.0] * 6 + [float(rate_of_axes)] * 3)
            if not (np.all(np.isfinite(slope)) and rate_of_axes > 0):
                break
            step = np.linalg.lstsq(slope * columns / rows[:, None], -force / rows, rcond=NEUTRAL_TOLERANCE)[0]
            largest = float(np.max(np.abs(step)))
            here = here._moved(step * (MAX_STEP / max(largest, MAX_STEP)) * columns)
            if np.max(np.abs(force / rows)) < BALANCE_TOLERANCE and largest < np.sqrt(BALANCE_TOLERANCE):
                return here
        raise ValueError(
            f"guess must be near a relative equilibrium, got none at the distance {np.linalg.norm(self.position):.6g}. "
            "Only a body that is symmetric about an axis may spin about it."
        )

    def _moved(self, step: Array) -> _PairBalance:
        turns = np.array([[1.0, *step[:3] / 2], [1.0, *step[3:6] / 2]])
        attitudes = quat.product(self.attitudes, turns / np.linalg.norm(turns, axis=1, keepdims=True))
        return dataclasses.replace(self, attitudes=attitudes, rate=self.rate + step[6:])

    # ------------------------------------------------------------------ small motion

    def equilibrium(self, time: Any) -> PairEquilibrium:
        """Return the equilibrium with its linear equations."""
        matrix, units, rate_of_axes = self._rates_and_matrix[1], self.units, float(np.linalg.norm(self.rate))
        scaled = matrix * units / units[:, None] / rate_of_axes
        point = PairPoint(self.attitudes, np.array(self.momenta), self.position, self.momentum)
        left = point.free(self.rate / rate_of_axes, self.axes, units)
        eigenvalues = np.linalg.eigvals(left.T @ scaled @ left)
        slow = _slow(eigenvalues)
        growth = rate_of_axes * np.sort(eigenvalues.real[eigenvalues.real > slow])
        frequencies = rate_of_axes * np.sort(eigenvalues.imag[eigenvalues.imag > slow])
        stability = "unstable" if growth.size else self._stability(scaled, left, eigenvalues)
        omegas = [np.asarray(omega) for omega in self.omegas]
        velocity = np.cross(self.rate, self.position)
        state = self.flow.system.body.state(self.position, velocity, list(self.attitudes), omega_body=omegas, time=time)
        return PairEquilibrium(
            self.flow.system, state, self.rate, matrix, rate_of_axes * eigenvalues, frequencies, growth, stability
        )

    def _stability(self, scaled: Array, left: Array, eigenvalues: Array) -> str:
        """Return the kind of stability if no solution grows exponentially."""
        poisson = np.zeros((18, 18))
        for i, g in enumerate(self.momenta):
            turn, own = slice(6 * i, 6 * i + 3), slice(6 * i + 3, 6 * i + 6)
            poisson[turn, own], poisson[own, turn], poisson[own, own] = np.eye(3), -np.eye(3), cross_matrix(g)
        poisson[12:15, 15:], poisson[15:, 12:15] = np.eye(3), -np.eye(3)
        units, rate_of_axes = self.units, float(np.linalg.norm(self.rate))
        energy = np.linalg.inv(poisson / units[:, None] / units) @ scaled * rate_of_axes
        energy = left.T @ (energy + energy.T) @ left / 2
        size = np.sqrt(np.abs(np.diag(energy)))  # so that a small body has the weight of a large one
        curvature = np.linalg.eigvalsh(energy / size / size[:, None])
        slow = _slow(eigenvalues)
        if np.min(np.abs(curvature)) < RATE_TOLERANCE**2 or grows_with_time(left.T @ scaled @ left, eigenvalues, slow):
            return "undecided"
        return "lyapunov" if np.min(curvature) > 0 else "linear"


class _Flow:
    """Equations of motion of two bodies in rotating axes, with their derivatives, as a graph."""

    def __init__(self, system: System[TwoBodies]) -> None:
        self.system, self.bodies = system, system.of_bodies.values()
        self.mass = float(system.body.reduced_mass)

    def evaluated(self, values: Sequence[float]) -> tuple[Array, Array]:
        """Return the rates of the 18 coordinates, and their derivatives by the coordinates, (18, 18).

        Values are quaternion and momentum of the primary and of the secondary, position, momentum, and the rate.
        """
        symbols, outputs = self._traced
        found = symbols[0].graph.evaluated(outputs, dict(zip(symbols, values, strict=True)))
        table = np.array(found, dtype=float).reshape(18, -1)
        by, slopes = table[:, 1:], np.empty((18, 18))
        for i in range(2):
            q = np.array(values[7 * i : 7 * i + 4], dtype=float)
            turns = np.array([quat.product(q, half) for half in HALF_TURNS])
            slopes[:, 6 * i : 6 * i + 3] = by[:, 7 * i : 7 * i + 4] @ turns.T
            slopes[:, 6 * i + 3 : 6 * i + 6] = by[:, 7 * i + 4 : 7 * i + 7]
        slopes[:, 12:] = by[:, 14:20]
        return table[:, 0].copy(), slopes

    @cached_property
    def _traced(self) -> tuple[list[Node], list[Any]]:
        graph = Graph()
        symbols = [graph.symbol(i) for i in range(23)]
        attitudes = [Attitude.from_quaternion(symbols[i : i + 4]) for i in (0, 7)]
        momenta = [Vector(symbols[i : i + 3]) for i in (4, 11)]
        position, momentum, rate = (Vector(symbols[i : i + 3]) for i in (14, 17, 20))
        instant = PairInstant(self.system.body, attitudes, position, Environment(0.0), momentum, momenta)
        turnings, own = self.system.dynamics.changes(instant)
        rates: list[Any] = []
        for each in turnings:
            rates += [*(each.omega - each.attitude.to_body(rate)), *each.momentum_rate]
        speed, force = Vector(own["orbit"][:3]), Vector(own["orbit"][3:])
        rates += [*(speed - cross(rate, position)), *(force - cross(rate, momentum))]
        return symbols, [x for each in rates for x in (each, *gradient(each, symbols[:20]))]


def _slow(eigenvalues: Array) -> float:
    """Return the size below which eigenvalues, divided by the rate of the axes, count as zero."""
    return max(RATE_TOLERANCE, EIGENVALUE_ROUNDING * float(np.max(np.abs(eigenvalues))))
