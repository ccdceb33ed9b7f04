"""Relative equilibria: attitudes at rest in a uniformly turning frame, their small oscillations and stability.

The vector x = (rotation vector, angular momentum), both along the body axes, obeys x' = matrix x to first order. The
matrix is the derivative of the equations of the system, which Newton's method also uses to find the equilibria. For
satellites on circular orbits this is the analysis of DeBra and Delp (1961, J. Astronaut. Sci. 8, 14): "lyapunov" is
the stability region of Lagrange, "linear" the region of DeBra and Delp.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.analysis.polynomial_search import zeros_of_quartics
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.functions import Vector
from poinsot.immutable import cached_property
from poinsot.integration.scaling import momentum_scale
from poinsot.kinematics.attitude import Attitude, rotation, rotation_angle, unit_quaternion
from poinsot.kinematics.frame import Frame, RotatingFrame, checked_frame
from poinsot.kinematics.state import State
from poinsot.mechanics.body import Body
from poinsot.mechanics.environment import Environment
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.printable import quoted
from poinsot.quantities import Array, Time
from poinsot.records.units import PER_TIME
from poinsot.systems.body_dynamics import BodyDynamics
from poinsot.systems.dynamics import Turning
from poinsot.systems.probing import time_scale
from poinsot.systems.system import OfOneBody, System
from poinsot.systems.times_and_states import checked_time
from poinsot.taylor.graph import Graph, Node, gradient

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["HALF_TURNS", "Equilibrium", "equilibria", "grows_with_time"]

RATE_TOLERANCE = 1e-6
"""Relative size of rates that count as zero; its square for stiffnesses. Both are larger in oblique axes."""
SAME_ATTITUDE = 1e-5
"""Largest angle between equal attitudes, radians: where a stiffness vanishes, attitudes are less accurate."""
UNIFORMITY_TOLERANCE = 1e-9
"""Largest change of rates and torques, relative to their size, between times in a uniform frame."""
RANDOM_STARTS = 100
MAX_ITERATIONS = 60
MAX_STEP = 0.5
"""Largest step of Newton's method, radians."""
OFF_COURSE = np.array([0.07, -0.11, 0.05])
"""Rotation vector away from symmetric attitudes, where the shortest path to another equilibrium has no direction."""
HALF_TURNS = np.eye(4)[1:] / 2


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(Summarized):
    """Attitude at rest in a frame, with the stability of small motions about it; radians, the user's unit of time.

    Attributes
    ----------
    attitude : array (4,)
        Unit quaternion body -> frame, or body -> space without a frame.
    state : State
        State at rest in the frame.
    matrix : array (6, 6)
        Matrix of the linear equations x' = matrix x, x = (rotation vector relative to the frame, change of angular
        momentum), body axes.
    eigenvalues : complex array (6,)
        Eigenvalues of the matrix.
    frequencies, growth_rates : arrays, ascending
        Positive imaginary and real parts of the eigenvalues, without parts below 1e-6 of the fastest rate.
    stability : {"lyapunov", "asymptotic", "linear", "unstable", "undecided"}
        "lyapunov": U - omega . I omega / 2 - h . omega has a minimum, with the angular velocity omega of the frame and
        the momentum h of rotors. "asymptotic": all eigenvalues have negative real parts. "linear": no solution of the
        linear equations grows, but the energy proves nothing. "unstable": a solution grows. "undecided": terms of
        higher order decide. A motion along the family of equilibria does not count.
    family : int
        Dimension of the continuous family of equilibria that this one represents; 0 if it is isolated.

    Examples
    --------
    >>> top = pt.System(pt.Body((1.0, 1.0, 0.5)), pt.UniformGravity(0.5, (0, 0, 0.5)))
    >>> upright, hanging = pt.analysis.equilibria(top)
    >>> upright.stability, hanging.stability, hanging.frequencies  # sqrt(0.5 * 0.5 / 1.0)
    ('unstable', 'lyapunov', array([0.5, 0.5]))
    """

    attitude: Array
    state: State
    matrix: Array
    eigenvalues: Array
    frequencies: Array
    growth_rates: Array
    stability: str
    family: int

    @property
    def stable(self) -> bool:
        """True if the stability is "lyapunov", "asymptotic" or "linear"."""
        return self.stability in ("lyapunov", "asymptotic", "linear")

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"Equilibrium: {self.stability}", {
            "attitude (quaternion, body to frame)": formatted(self.attitude),
            "frequencies": formatted(self.frequencies, PER_TIME),
            "growth rates": formatted(self.growth_rates, "per unit of time"),
            "dimension of its family": formatted(self.family) if self.family else "",
        }


@checked
def equilibria(
    system: OfOneBody, frame: Frame | None = None, *, guesses: Rotation | ArrayLike | None = None, time: Time = 0.0
) -> list[Equilibrium]:
    """Return the relative equilibria of a system: its attitudes at rest in a uniformly rotating frame.

    Equilibria satisfy g x omega + tau = 0 with the angular velocity omega of the frame and the torque tau. If this
    equation is a polynomial of fourth degree in the quaternion (gravity gradients, uniform fields, rotors) and all its
    zeros are isolated, the function finds all of them. Otherwise Newton's method searches and may miss some. A
    continuous family (any angle about the vertical) is returned once.

    Parameters
    ----------
    system : System
        System of one body, not an ensemble. Its parts must be without variables, such as a `Gyrostat`.
    frame : Frame, optional
        `orbit.frame` of a circular orbit, or a `RotatingFrame`, about the vertical for a top or about the angular
        momentum for a free body. Default: the space axes, for bodies at rest.
    guesses : scipy Rotation or array (n, 4), optional
        Initial attitudes body -> frame of Newton's method, which replace the search for all equilibria.
    time : float
        Time of the states. The equilibria do not depend on it.

    Returns
    -------
    list of Equilibrium
        Equilibria with their linear stability.

    Raises
    ------
    ValueError
        If the frame does not rotate uniformly, or the system depends on time in this frame.

    Examples
    --------
    >>> orbit = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
    >>> system = pt.System(pt.Body((1.0, 1.3, 1.6)), pt.GravityGradient(orbit))
    >>> found = pt.analysis.equilibria(system, orbit.frame)
    >>> len(found), sum(e.stability == "lyapunov" for e in found)
    (24, 4)
    """
    if moving := [type(part).__name__ for part in system.parts if part.size]:
        raise ValueError(f"system must have no parts with variables, got {moving[0]}. Hold rotors by a Gyrostat.")
    if system.members:
        raise ValueError(f"system must be a single one, got {system.members[0]} members. Take the members one by one.")
    frame = RotatingFrame((1, 0, 0, 0), (0, 0, 0)) if frame is None else checked_frame(frame)
    _refuse_span("system", system.span)
    _refuse_span("frame", getattr(getattr(frame, "orbit", None), "span", (-np.inf, np.inf)))
    balance = _Balance(system, frame, float(checked_time("time", time, system)))
    with np.errstate(all="ignore"):
        _check_frame(balance, frame)
        _check_same_at_all_times(balance, frame)
        starts = balance.starts() if guesses is None else np.atleast_2d(unit_quaternion(guesses, "guesses"))
        points, settled = balance.settled(starts)
        return balance.equilibria(balance.distinct(points[settled]), frame)


class _Balance:
    """Balance of torques on a body at rest in a frame, and its derivatives, at one time.

    Attitudes p are unit quaternions body -> frame, shape (n, 4).
    """

    def __init__(self, system: System[Body], frame: Frame, time: Time) -> None:
        self.system, self.time = system, time
        self.to_space, self.omega_space = frame.quaternion(time), np.asarray(frame.omega_space(time))
        self.dynamics = BodyDynamics(system.body, system.forces)
        self.body = self.dynamics.body_at({}, time)
        largest, rate = float(np.max(system.body.moments)), float(np.linalg.norm(self.omega_space))
        at_rest = system.body.state((1, 0, 0, 0), angular_momentum_body=(0, 0, largest * rate))
        rotors = float(np.linalg.norm(self.body.angular_momentum(np.zeros(3))))
        rigid = float(momentum_scale(self.dynamics, at_rest))
        self.momentum, self.stiffness = rigid + rotors, rigid**2 / largest + rotors * rate
        self.slenderness = _slenderness(system.body)
        self.slow = min(RATE_TOLERANCE * self.slenderness, 0.01)

    # ------------------------------------------------------------------ equations

    def flow(self, p: Array) -> tuple[Array, Array]:
        """Return the rates (n, 6) of rotation vector and momentum, and their derivatives by both, (n, 6, 6)."""
        q = quat.product(self.to_space, p)
        g = self.body.angular_momentum(Attitude.from_quaternion(q.T).to_body(self.omega_space))
        symbols, outputs = self._traced
        values = symbols[0].graph.evaluated(outputs, dict(zip(symbols, (*q.T, *g), strict=True)))
        table = np.array([np.broadcast_to(x, len(p)) for x in values], dtype=float).reshape(6, 8, len(p))
        turns = [quat.product(q, half_turn) for half_turn in HALF_TURNS]
        by_turn, by_momentum = np.einsum("iqn,knq->nik", table[:, 1:5], turns), np.moveaxis(table[:, 5:], -1, 0)
        return table[:, 0].T, np.concatenate([by_turn, by_momentum], axis=-1)

    @cached_property
    def _traced(self) -> tuple[list[Node], list[Any]]:
        """Symbols of quaternion and momentum, and the rates, each with its derivatives by the symbols."""
        graph = Graph()
        symbols = [graph.symbol(i) for i in range(7)]
        attitude, momentum = Attitude.from_quaternion(symbols[:4]), Vector(symbols[4:])
        instant = Instant(self.body, attitude, Environment(self.time), angular_momentum_body=momentum)
        change = Turning.of(instant, self.dynamics.torque_at(instant)).momentum_rate
        rates = (*(instant.omega_body - attitude.to_body(self.omega_space)), *change)
        return symbols, [x for rate in rates for x in (rate, *gradient(rate, symbols))]

    def imbalance(self, p: Array) -> tuple[Array, Array]:
        """Return g x omega + tau of the body at rest in the frame, (n, 3), and its derivative by turns, (n, 3, 3)."""
        rates, matrix = self.flow(p)
        return rates[:, 3:], _slope(matrix)

    def torques(self, p: Array) -> tuple[Array, Array]:
        """Return the rate of the momentum, (n, 3), and its derivatives by turn and omega, (n, 3, 6), as torques."""
        rates, matrix = self.flow(p)
        by_omega = matrix[:, 3:, 3:] @ np.linalg.inv(matrix[:, :3, 3:]) * (self.stiffness / self.momentum)
        return rates[:, 3:], np.concatenate([matrix[:, 3:, :3], by_omega], axis=-1)

    # ------------------------------------------------------------------ search

    def starts(self) -> Array:
        """Return attitudes with principal axes along the axes of the frame, and zeros of a polynomial or a sample."""
        from scipy.spatial.transform import Rotation

        ways = Rotation.create_group("O").as_quat(canonical=True, scalar_first=True)
        ways = ways[np.argsort(-ways[:, 0], kind="stable")]  # the smallest turns first
        to_principal = self.system.body.principal_axes.inv().as_quat(scalar_first=True)
        near, all_of_them = zeros_of_quartics(lambda p: self.imbalance(p)[0], _random_attitudes(RANDOM_STARTS))
        others = [] if all_of_them else [_random_attitudes(RANDOM_STARTS)]
        return np.concatenate([quat.product(ways, to_principal), near, *others])

    def settled(self, p: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return the attitudes at which Newton's method ends, and a mask of the equilibria among them, (n,)."""
        p, moving = p.copy(), np.arange(len(p))
        settled = np.zeros(len(p), dtype=bool)
        for _ in range(MAX_ITERATIONS):
            if not moving.size:
                break
            force, slope = self.imbalance(p[moving])
            finite = np.isfinite(force).all(axis=-1) & np.isfinite(slope).all(axis=(-1, -2))
            moving, force, slope = moving[finite], force[finite], slope[finite]
            step = -np.einsum("nij,nj->ni", self._inverse(slope), force)
            size = np.linalg.norm(step, axis=-1)
            p[moving] = _turned(p[moving], step * np.minimum(1, MAX_STEP / np.maximum(size, 1e-300))[:, None])
            # The error after a step is of the order of its square, unless a stiffness vanishes.
            small = (size < RATE_TOLERANCE / 10) & (np.linalg.norm(force, axis=-1) < RATE_TOLERANCE * self.stiffness)
            settled[moving[small]] = True
            moving = moving[~small]
        return p, settled

    def distinct(self, points: Array) -> Array:
        """Return one attitude of each family, the first."""
        chosen: list[Array] = []
        free = self._free(points)
        while len(points):
            chosen.append(points[0])
            others = rotation_angle(points, chosen[-1]) > SAME_ATTITUDE
            points, free = points[others], free[others]
            others = rotation_angle(self._slid(points, free, chosen[-1]), chosen[-1]) > SAME_ATTITUDE
            points, free = points[others], free[others]
        return np.array(chosen)

    def _slid(self, points: Array, free: Array, target: Array) -> Array:
        """Return attitudes moved towards a target, along directions without stiffness."""
        points, free = points.copy(), free.copy()
        sliding = np.flatnonzero(np.any(free, axis=(-1, -2)))
        for start in (True, *(False,) * MAX_ITERATIONS):
            way = rotation(quat.product(quat.conjugate(points[sliding]), target)).as_rotvec() + OFF_COURSE * start
            step = np.einsum("nij,nj->ni", free[sliding], way)
            size = np.linalg.norm(step, axis=-1)
            sliding, step, size = (
                sliding[size > RATE_TOLERANCE],
                step[size > RATE_TOLERANCE],
                size[size > RATE_TOLERANCE],
            )
            if not sliding.size:
                break
            step *= np.minimum(1, MAX_STEP / size)[:, None]
            points[sliding], _ = self.settled(_turned(points[sliding], step))
            free[sliding] = self._free(points[sliding])
        return points

    def _free(self, points: Array) -> Array:
        """Return the projections on the turns without stiffness, (n, 3, 3)."""
        return self._without_stiffness(self.imbalance(points)[1]) if len(points) else np.empty((0, 3, 3))

    def _without_stiffness(self, slope: Array) -> Array:
        """Return the projections on the turns without stiffness, (n, 3, 3), from the slopes of the balance."""
        _, stiffness, axes = np.linalg.svd(slope)
        free = axes * (stiffness <= RATE_TOLERANCE * self.slow * self.stiffness)[..., None]
        return np.asarray(np.swapaxes(free, -1, -2) @ free)

    def _inverse(self, slope: Array) -> Array:
        """Return the pseudo-inverses, which are zero in directions without stiffness."""
        left, stiffness, right = np.linalg.svd(slope)
        firm = stiffness > RATE_TOLERANCE * self.slow * self.stiffness
        inverse = np.where(firm, 1 / np.where(firm, stiffness, 1), 0)
        return np.asarray(np.swapaxes(right, -1, -2) @ (inverse[..., None] * np.swapaxes(left, -1, -2)))

    # ------------------------------------------------------------------ small motion

    def equilibria(self, points: Array, frame: Frame) -> list[Equilibrium]:
        """Return the equilibria at attitudes."""
        if not len(points):
            return []
        points = points / np.linalg.norm(points, axis=-1, keepdims=True)
        matrices = self.flow(points)[1]
        frees = self._without_stiffness(_slope(matrices))
        return [self._equilibrium(*each, frame) for each in zip(points, matrices, frees, strict=True)]

    def _equilibrium(self, p: Array, matrix: Array, free: Array, frame: Frame) -> Equilibrium:
        """Return the equilibrium at an attitude, from its linear equations and the turns without stiffness."""
        unit = np.array([1.0] * 3 + [self.momentum] * 3)
        scaled = matrix * unit / unit[:, None]
        eigenvalues = np.linalg.eigvals(scaled)
        fastest = max(np.max(np.abs(eigenvalues)), self.stiffness / self.momentum)
        slow = self.slow * float(fastest)
        frequencies = np.sort(eigenvalues.imag[eigenvalues.imag > slow])
        growth = np.sort(eigenvalues.real[eigenvalues.real > slow])
        family = self._family(p, free)
        stability = "unstable" if growth.size else self._stability(scaled, eigenvalues, slow, free, family)
        state = self.system.state(p, omega_body=(0, 0, 0), time=self.time, frame=frame)
        return Equilibrium(p, state, matrix, eigenvalues, frequencies, growth, stability, family)

    def _stability(self, scaled: Array, eigenvalues: Array, slow: float, free: Array, family: int) -> str:
        """Return the kind of stability of an equilibrium at which nothing grows exponentially."""
        freedom = round(float(np.trace(free)))
        if family < freedom or grows_with_time(scaled, eigenvalues, slow):
            return "undecided"
        if any(isinstance(force, Torque) for force in self.system.forces):
            dies = int(np.sum(eigenvalues.real < -slow))
            return "asymptotic" if dies == 6 - freedom else "linear"
        slope = self.momentum * _slope(scaled[None])[0]
        curvature = np.linalg.eigvalsh(-(slope + slope.T) / 2)  # second derivative of U - Omega . I Omega / 2
        positive = int(np.sum(curvature > RATE_TOLERANCE * self.slow * self.stiffness))
        return "lyapunov" if positive == 3 - freedom else "linear"

    def _family(self, p: Array, free: Array) -> int:
        """Return the number of directions without stiffness that contain equilibria at a finite distance."""
        stiffness, axes = np.linalg.eigh(free)
        steps = 0.1 * axes.T[stiffness > 0.5]
        if not len(steps):
            return 0
        ends, settled = self.settled(_turned(np.broadcast_to(p, (len(steps), 4)), steps))
        return int(np.sum(settled & (rotation_angle(ends, p) > 0.05) & np.any(self._free(ends), axis=(-1, -2))))


def _slenderness(body: Body) -> float:
    """Return the growth of rounding errors from momenta to rates, which is 1 in principal axes."""
    oblique = np.any(body.inertia != np.diag(np.diag(body.inertia)))
    return float(np.max(body.moments) / np.min(body.moments)) if oblique else 1.0


def _slope(matrix: Array) -> Array:
    """Return the derivative of g' by turns at the omega of the frame, from the derivative of the flow, (n, 3, 3)."""
    return np.asarray(matrix[:, 3:, :3] - matrix[:, 3:, 3:] @ np.linalg.solve(matrix[:, :3, 3:], matrix[:, :3, :3]))


def grows_with_time(matrix: Array, eigenvalues: Array, slow: float) -> bool:
    """Return True if equal frequencies have too few eigenvectors, so that oscillations grow like t cos(w t)."""
    for eigenvalue in eigenvalues[np.abs(eigenvalues.imag) > slow]:
        cluster = eigenvalues[np.abs(eigenvalues - eigenvalue) < 10 * slow]
        distance = np.linalg.svd(matrix - np.mean(cluster) * np.eye(len(matrix)), compute_uv=False)
        if np.sum(distance < 100 * slow) < len(cluster):
            return True
    return False


# ---------------------------------------------------------------------- checks


def _refuse_span(name: str, span: tuple[float, float]) -> None:
    if np.isfinite(span[1] - span[0]):
        raise ValueError(
            f"{name} must be the same at all times, but an ephemeris, known for [{quoted(span[0])}, "
            f"{quoted(span[1])}], is not. "
            "Take an orbit with a formula."
        )


def _check_frame(balance: _Balance, frame: Frame) -> None:
    rates = np.stack([frame.omega_space(time) for time in _other_times(balance)])
    change = np.max(np.linalg.norm(rates - balance.omega_space, axis=-1))
    fastest = np.max(np.linalg.norm(rates, axis=-1))
    if change > UNIFORMITY_TOLERANCE * fastest:
        raise ValueError(
            f"frame must turn uniformly, but its angular velocity changes by {change / fastest:.2g} of its size. "
            "That of an orbit does if the orbit is a circle."
        )


def _check_same_at_all_times(balance: _Balance, frame: Frame) -> None:
    attitudes = _random_attitudes(4)
    here = balance.torques(attitudes)
    if not all(np.isfinite(part).all() for part in here):
        raise ValueError(
            "system must have a torque with a derivative where the body is at rest in the frame, but it is not finite. "
            "The norm of a zero vector has no derivative."
        )
    for time in _other_times(balance):
        there = _Balance(balance.system, frame, time).torques(attitudes)
        change = max(np.max(np.abs(a - b)) for a, b in zip(here, there, strict=True))
        if not change <= UNIFORMITY_TOLERANCE * balance.slenderness * balance.stiffness:
            raise ValueError(
                "system must look the same from the frame at all times, but its torque changes by "
                f"{change:.2g} until t = {time:.6g}. Name the frame with which the forces turn, such as orbit.frame."
            )


def _other_times(balance: _Balance) -> list[float]:
    """Return times a fraction of a turn away, and several turns."""
    rate = np.linalg.norm(balance.omega_space)
    unit = 1 / rate if rate > 0 else time_scale(balance.system.dynamics)
    return [float(balance.time) + float(unit) * step for step in (0.7, 2.3, -37.0)]


# ---------------------------------------------------------------------- attitudes


def _random_attitudes(count: int) -> Array:
    q = np.random.default_rng(20061027).normal(size=(count, 4))
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def _turned(p: Array, turn: Array) -> Array:
    """Return attitudes turned by rotation vectors along the body axes, (n, 3)."""
    half = np.linalg.norm(turn, axis=-1, keepdims=True) / 2
    p = quat.product(p, np.concatenate([np.cos(half), turn / 2 * np.sinc(half / np.pi)], axis=-1))
    return np.asarray(p / np.linalg.norm(p, axis=-1, keepdims=True))
