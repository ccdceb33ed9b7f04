"""Positions of the body relative to attractors: orbits, blocks of their variables, and values at one instant."""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.errors import real_numbers, scalar
from poinsot.functions import ComovingVector, Scalar, Vector
from poinsot.immutable import Immutable, cached_property
from poinsot.kinematics.frame import Frame, RelativeOrbitFrame
from poinsot.mechanics.block import Block
from poinsot.quantities import Times
from poinsot.records.members import at_times, with_times
from poinsot.records.parameters import Parametric, same
from poinsot.taylor.graph import Graph, tangents

__all__ = [
    "SPACE_AXES_UNNAMED",
    "Dated",
    "Environment",
    "EnvironmentOfStates",
    "FrameOfOrbit",
    "Orbit",
    "OrbitBlock",
    "Views",
    "frames_of",
    "orbits_of",
    "sample_time",
    "shared_blocks",
    "viewed",
    "within",
]

SPACE_AXES_UNNAMED = "space axes"
"""The reference frame of an orbit whose axes have no other name than the user's."""


OF_DATE = "TEME"
"""Axes that move among the stars, by 50 arcseconds a year: nobody means them by chance."""


class Dated(Parametric):
    """Base of records along named space axes, at times that may be dates: orbits, rotation models, fields, air."""

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of the data."""
        return -np.inf, np.inf

    @property
    def reference_frame(self) -> str:
        """Name of the space axes."""
        return SPACE_AXES_UNNAMED

    @property
    def calendar(self) -> Any:
        """Calendar that converts times to dates; None if times are numbers alone."""
        return None


class Orbit(Dated, ABC):
    """Position of the body relative to one attractor, space axes; the base class of all orbits.

    A subclass declares the gravitational parameter `mu` of the attractor and defines position and velocity as formulas
    of the time.

    Examples
    --------
    >>> class Line(pt.Orbit):
    ...     mu: float
    ...     speed: float
    ...     def position_at(self, time):
    ...         return pt.functions.Vector((self.speed * time, 1.0, 0.0))
    ...     def velocity_at(self, time):
    ...         return pt.functions.Vector((self.speed, 0.0, 0.0))
    >>> round(float(Line(1.0, 2.0).inverse_distance_at(0.5)), 4)
    0.7071
    """

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        for name, formula in list(vars(cls).items()):
            if name.endswith("_at") and not name.startswith("_"):
                setattr(cls, name, _of_time(formula))

    if TYPE_CHECKING:

        @property
        def mu(self) -> Scalar:
            """Gravitational parameter of the attractor."""

    @abstractmethod
    def position_at(self, time: Scalar) -> Vector:
        """Return the three components of the position of the body relative to the attractor, space axes.

        Each component has the shape of the time. With members, and times of shape (n,) common to all, each has shape
        (members, n).
        """

    @abstractmethod
    def velocity_at(self, time: Scalar) -> Vector:
        """Return the three components of the velocity of the body relative to the attractor, space axes."""

    def inverse_distance_at(self, time: Scalar) -> Scalar:
        """Return the inverse 1 / r of the distance from the attractor."""
        return 1 / functions.norm(self.position_at(time))

    def hidden_at(self, time: Scalar) -> Mapping[str, Scalar]:
        """Return, by reason, True at times of reception at which an observer at the attractor does not see the body."""
        scalar("time", time)
        return {}

    @property
    def closed_form(self) -> bool:
        """True if the formulas accept symbols."""
        return True

    @property
    def integrated(self) -> bool:
        """True if a kernel integrates the orbit in any axes; False if in comoving axes only."""
        return not self.closed_form

    @property
    def sample_time(self) -> Any:
        """Time at which the attractor acts, for trials of formulas; shape () or (members,)."""
        return 0.0

    @property
    def sample_reach(self) -> Any:
        """Interval around the time in which formulas may be evaluated; shape () or (members,)."""
        return np.inf

    @property
    def origin(self) -> str:
        """Name of the attractor."""
        return "attractor"

    @property
    def block(self) -> OrbitBlock | None:
        """Variables that a kernel may integrate instead of the formulas, or None."""
        return None

    @property
    def uniform_rotation(self) -> NDArray[np.float64] | None:
        """Angular velocity, space axes, about which the position rotates uniformly, or None for any other orbit."""
        return None

    @property
    def directions(self) -> dict[str, NDArray[np.float64]]:
        """Directions in space that the orbit singles out, by name: candidates for an integral."""
        return {}

    @property
    def frame(self) -> Frame:
        """Axes radial (away from the attractor), transverse (forward), and normal to position and velocity."""
        return FrameOfOrbit(self)


class FrameOfOrbit(RelativeOrbitFrame):
    """The axes radial, transverse and normal of any orbit, by the formulas of its position and its velocity."""

    def __init__(self, orbit: Orbit) -> None:
        self.orbit = orbit
        super().__init__(self._moving_at)

    @property
    @override
    def member_axis(self) -> tuple[int, ...]:
        return self.orbit.member_axis

    def _moving_at(self, time: Times) -> tuple[NDArray[np.float64], ...]:
        """Return position, velocity and its derivative."""
        orbit, t = with_times(self.orbit, real_numbers("time", time))
        graph = Graph()
        now = graph.variable(t)
        velocity = Vector(orbit.velocity_at(now))
        acceleration = graph.finished(tangents(list(velocity), {now: 1.0}))
        shape = np.broadcast_shapes(self.member_axis + (1,) * (np.ndim(t) - 1), np.shape(t))
        vectors = orbit.position_at(t), orbit.velocity_at(t), acceleration
        return tuple(np.stack([np.broadcast_to(x, shape) for x in vector], axis=-1) for vector in vectors)


def _of_time(formula: Callable[..., Any]) -> Callable[..., Any]:
    """Return a formula of the time that checks the time, and that broadcasts times against the numbers of members."""

    @functools.wraps(formula)
    def checked(self: Any, time: Any) -> Any:
        return at_times(formula, self, scalar("time", time))

    return checked


def frames_of(named: Iterable[str]) -> list[str]:
    """Return the names of space axes, each once: those without a name go with any but those of date."""
    names = dict.fromkeys(named)
    if OF_DATE not in names:
        names.pop(SPACE_AXES_UNNAMED, None)
    return list(names)


class OrbitBlock(Block):
    """The variables of an orbit, and the comoving axes that they give; orbits about several attractors may view one.

    `own` are the variables, scalars of any kind; vectors are along the comoving axes unless their name says otherwise.
    """

    @property
    @override
    def _member_axes(self) -> dict[str, int]:
        return {"numbers": 0}

    @override
    def _with_values(self, **values: Any) -> Self:
        return self.with_numbers(values["numbers"])

    @abstractmethod
    def start_at(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the variables at a time; shape (..., size)."""

    @abstractmethod
    def rates_at(self, time: Scalar, own: Any) -> Vector:
        """Return the time derivatives of the variables."""

    @abstractmethod
    def omega(self, time: Scalar, own: Any) -> Vector:
        """Return the inertial angular velocity of the axes."""

    @abstractmethod
    def quaternion(self, time: NDArray[np.float64], own: Any) -> NDArray[np.float64]:
        """Return the unit quaternions axes -> space; shape (..., 4)."""

    @abstractmethod
    def to_space(self, vector: Any, time: Scalar, own: Any) -> Vector:
        """Return a vector along the space axes."""

    @abstractmethod
    def position(self, orbit: Orbit, time: Scalar, own: Any) -> Vector:
        """Return the position of the body from the attractor of one of the orbits."""

    @abstractmethod
    def velocity(self, orbit: Orbit, time: Scalar, own: Any) -> Vector:
        """Return its inertial velocity relative to that attractor."""

    @abstractmethod
    def inverse_distance(self, orbit: Orbit, time: Scalar, own: Any) -> Scalar:
        """Return one over the length of the position."""

    def start_in_two_parts(self, time: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], Any]:
        """Return the variables at a time, high and low part, and the quaternion space -> axes there, both extended.

        The last result is stored: systems on one orbit usually start at one time.
        """
        key = time.shape, time.tobytes()
        known = self._starts.get(key)
        if known is None:
            wide = self.with_numbers(map(np.longdouble, self.numbers))  # to round once, at the end
            values = wide.start_at(time)
            high = np.asarray(values, dtype=np.float64)
            turn = quat.conjugate(wide.quaternion(time, values))
            known = high, np.asarray(values - high, dtype=np.float64), turn
            self._starts.clear()
            self._starts[key] = known
        return known

    @cached_property
    def _starts(self) -> dict[Any, Any]:
        return {}

    def direction(self, orbit: Orbit, time: Scalar, own: Any) -> Vector:
        """Return the unit vector from the attractor."""
        inverse = self.inverse_distance(orbit, time, own)
        return Vector(x * inverse for x in self.position(orbit, time, own))


class Environment(Immutable):
    """Positions and velocities on orbits at one instant, from integrated variables or from formulas.

    Parameters
    ----------
    time : scalar
        Time of the instant.
    blocks : sequence of pairs
        Blocks of integrated orbits with the values of their variables.
    views : mapping, optional
        Map from the `id` of an orbit to the number of its block, or None for an orbit without a block. By default, an
        orbit uses the block with equal parameters.
    comoving : bool
        True if vectors are along the comoving axes of one block that all orbits share.

    Examples
    --------
    >>> orbit = pt.orbits.FixedPosition(1.0, position=(0, 2, 0))
    >>> float(pt.mechanics.Environment(time=0.0).inverse_distance(orbit))
    0.5
    """

    time: Scalar

    def __init__(
        self,
        time: Scalar,
        blocks: Sequence[tuple[OrbitBlock, Vector]] = (),
        views: Mapping[int, int | None] | None = None,
        comoving: bool = False,
    ) -> None:
        self.time = scalar("time", time)
        self.blocks, self._views, self._comoving = blocks, views, comoving

    def position(self, orbit: Orbit) -> Vector:
        """Return the position of the body relative to the attractor of an orbit, space axes."""
        if (found := self._found(orbit)) is None:
            return self._broadcast(orbit).position_at(self.time)
        block, own = found
        return self._vector(block.position(orbit, self.time, own), block, own)

    def velocity(self, orbit: Orbit) -> Vector:
        """Return the velocity of the body relative to the attractor of an orbit, space axes."""
        if (found := self._found(orbit)) is None:
            return self._broadcast(orbit).velocity_at(self.time)
        block, own = found
        return self._vector(block.velocity(orbit, self.time, own), block, own)

    def inverse_distance(self, orbit: Orbit) -> Scalar:
        """Return 1 / r, with the distance r of the body from the attractor of an orbit."""
        if (found := self._found(orbit)) is None:
            return self._broadcast(orbit).inverse_distance_at(self.time)
        block, own = found
        return block.inverse_distance(orbit, self.time, own)

    def direction(self, orbit: Orbit) -> Vector:
        """Return the unit vector from the attractor of an orbit to the body, space axes."""
        if (found := self._found(orbit)) is None:
            inverse = self.inverse_distance(orbit)
            return Vector(x * inverse for x in self.position(orbit))
        block, own = found
        return self._vector(block.direction(orbit, self.time, own), block, own)

    def own(self, block: Block) -> Vector:
        """Return the variables of the block of an orbit."""
        return next(own for each, own in self.blocks if each is block)

    @property
    def orbit_values(self) -> NDArray[np.float64] | None:
        """The variables of all blocks as the last axis of an array; None without one."""
        values = [x for _, own in self.blocks for x in own]
        return np.stack(values, axis=-1) if values else None

    def _found(self, orbit: Orbit) -> tuple[OrbitBlock, Vector] | None:
        """Return the block that an orbit views, and its values."""
        if self._views is not None:
            number = self._views.get(id(orbit))
            return None if number is None else self.blocks[number]
        path = orbit.block if self.blocks else None
        return next(((block, own) for block, own in self.blocks if path and same(block, path)), None)

    def _broadcast(self, orbit: Orbit) -> Orbit:
        """Return an orbit whose formulas take the time: of members, the times are common to all."""
        return orbit

    def _vector(self, vector: Vector, block: OrbitBlock, own: Vector) -> Vector:
        return ComovingVector(vector) if self._comoving else block.to_space(vector, self.time, own)


class EnvironmentOfStates(Environment):
    """Positions on orbits at the times of states, members first: each member's orbit at the time of its own state.

    Parameters
    ----------
    time : array
        The times of the states, or one for all.
    axes : int
        How many axes the states have.
    """

    def __init__(self, time: Any, axes: int) -> None:
        super().__init__(time)
        self._axes = axes

    @override
    def _broadcast(self, orbit: Orbit) -> Orbit:
        return orbit.with_axes(self._axes) if orbit.member_axis and self._axes else orbit


Views = tuple[int | None, ...]
"""For each of some orbits the number of the block that it views."""


def shared_blocks(orbits: Iterable[Orbit], wanted: Callable[[Orbit], bool]) -> tuple[tuple[OrbitBlock, ...], Views]:
    """Return the blocks of the orbits that are wanted, one for orbits on one path, and which of them each views."""
    blocks: list[OrbitBlock] = []
    views: list[int | None] = []
    for orbit in orbits:
        block = orbit.block if wanted(orbit) else None
        if block is None:
            views.append(None)
            continue
        views.append(next((i for i, known in enumerate(blocks) if same(known, block)), len(blocks)))
        blocks[views[-1] :] = blocks[views[-1] :] or [block]
    return tuple(blocks), tuple(views)


def viewed(orbits: Sequence[Orbit], views: Views) -> tuple[OrbitBlock, ...]:
    """Return the blocks that orbits view, each of the first that does."""
    count = len({number for number in views if number is not None})
    return tuple(block for i in range(count) if (block := orbits[views.index(i)].block) is not None)


def within(record: Any) -> Iterator[Any]:
    """Yield a record and those in it, in the order of fields; an orbit within another is no more than its shape."""
    yield record
    if not isinstance(record, Orbit):
        for part in record.records:
            yield from within(part)


def orbits_of(record: Any) -> Iterator[Orbit]:
    """Yield the orbits in a record, in the order of its fields."""
    return (part for part in within(record) if isinstance(part, Orbit))


def sample_time(orbits: Iterable[Orbit]) -> float:
    """Return a time at which orbits are felt; of members the first one's."""
    return next((float(t) for orbit in orbits for t in np.ravel(orbit.sample_time)[:1] if t), 0.0)
