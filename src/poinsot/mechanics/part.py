"""Parts that move inside a body or on it: rotors, dampers, masses on springs.

To add one, inside or outside the package, write a subclass: its fields are its parameters, `variables` what it
integrates, its methods the physics. It is frozen and becomes a dataclass by itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.algebra.quaternion import components
from poinsot.functions import Scalar, Vector
from poinsot.immutable import cached_property
from poinsot.mechanics.block import Block
from poinsot.mechanics.body import Body
from poinsot.mechanics.force import Force
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.kinetics import CompositeKinetics, Matrix, product
from poinsot.printable import quoted
from poinsot.records.members import Members, members_of, of_scalars
from poinsot.records.parameters import same

MAX_JUMP_NUMBER = 2.0**52
"""Largest number of a jump; larger numbers are not exact."""

__all__ = ["NOTHING", "CompositeBody", "Jump", "Part", "jumps_at", "named_parts", "parts_of", "tensor_array"]


class Jump(NamedTuple):
    """Sample times k period + offset of a part, for integer k.

    The variables of the part are constant between samples and change at each sample.

    Attributes
    ----------
    period, offset : scalar
        Sampling period and time of the sample k = 0, in units of time.
    draws : int
        Number of independent standard normal numbers that each sample receives.
    seed : scalar
        Seed of these numbers, used together with the number of the member and k.

    Examples
    --------
    >>> law = pt.control.Sampled(pt.control.RateDamping(2.0, limit=1.0), period=0.5)
    >>> float(law.jump.period), law.jump.draws
    (0.5, 0)
    """

    period: float | NDArray[np.float64]
    offset: float | NDArray[np.float64]
    draws: int = 0
    seed: float | NDArray[np.float64] = 0.0

    def first(self, times: ArrayLike) -> NDArray[np.float64]:
        """Return the numbers k of the first jumps that are not before times, in the rounding of k period + offset.

        Raises
        ------
        ValueError
            If a period is shorter than the rounding of a time.
        """
        numbers = np.ceil((np.asarray(times) - self.offset) / self.period) - 1
        if np.any(np.abs(numbers) > MAX_JUMP_NUMBER):
            least, time = float(np.min(self.period)), np.ravel(times)[0]
            raise ValueError(f"period must be longer than the rounding of the time, got {least} at t = {time:.10g}.")
        while (before := numbers * self.period + self.offset < np.asarray(times)).any():
            numbers = numbers + before
        return np.asarray(numbers)

    @property
    def _member_axes(self) -> dict[str, int]:
        return {"period": 0, "offset": 0, "seed": 0}

    def _with_values(self, **values: Any) -> Jump:
        return self._replace(**values)

    def falls_on(self, times: ArrayLike) -> NDArray[np.bool_]:
        """Return True for times at which there is a jump."""
        return np.asarray(self.first(times) * self.period + self.offset == times)


class Part(Block, Force):
    """Moving part in or on a body, with or without variables; the base class of wheels, dampers and controllers.

    The total angular momentum g about the centre of mass obeys g' = g x omega + external torque, regardless of internal
    motion. A part changes the relation omega = K (g - h) and the kinetic energy (g - h) . K (g - h) / 2 + internal
    energies. Torques of motors, friction and springs between body and part occur in `rates` only.

    The inertia tensor of the body includes all parts, locked where `inertia` is zero. The argument `own` of the methods
    contains the variables of the part, scalars of any kind in the order of `variables`. Matrices are rows of three
    scalars.

    Examples
    --------
    >>> class Rotor(pt.Part):
    ...     rate: float
    ...     def momentum(self, own, time):
    ...         return pt.functions.Vector((0.0, 0.0, self.rate * time))
    >>> system = pt.System(pt.Body((1.25, 1.0, 0.75)), Rotor(0.1))
    >>> start = system.state((1, 0, 0, 0), omega_body=(0, 0, 1))
    >>> pt.propagate(system, start, [3.0]).omega_body.round(4)
    array([[0. , 0. , 0.6]])
    """

    moves_center_of_mass: ClassVar[bool] = False
    """True if the part moves the centre of mass in the body; at most one part of a system may."""

    @property
    def jump(self) -> Jump | None:
        """Sample times of `update`, or None without samples. A motion with samples can only be integrated forwards."""
        return None

    @of_scalars
    def update(self, instant: Instant, draws: Vector) -> Vector:  # noqa: ARG002
        """Return the variables after a sample, from the instant before it and random numbers."""
        return instant.own(self)

    @of_scalars
    def start(self, time: Scalar, omega_body: Vector) -> Vector:  # noqa: ARG002
        """Return the initial values of the variables for a state that does not give them; zeros by default."""
        return Vector((0.0,) * self.size)

    @of_scalars
    def momentum(self, own: Vector, time: Scalar) -> Vector:  # noqa: ARG002
        """Return the angular momentum h at omega = 0 along the body axes. The momenta of all parts are added."""
        return Vector((0.0, 0.0, 0.0))

    @of_scalars
    def inertia(self, own: Vector, time: Scalar) -> Matrix:  # noqa: ARG002
        """Return the change of the mass distribution, an addition to the body's inertia on which gravity acts."""
        return NOTHING

    @of_scalars
    def spinning_inertia(self, own: Vector) -> Matrix:  # noqa: ARG002
        """Return the inertia that does not rotate with the body; it is subtracted in K^-1 only."""
        return NOTHING

    @of_scalars
    def internal_energy(self, own: Vector, time: Scalar) -> Scalar:  # noqa: ARG002
        """Return the energy of the part in addition to (g - h) . K (g - h) / 2."""
        return 0.0

    @of_scalars
    def rates(self, instant: Instant, generalised_force: Vector) -> Vector:  # noqa: ARG002
        """Return the time derivatives of the variables.

        Parameters
        ----------
        instant : Instant
            Instant of the body; `instant.own(self)` returns the variables of the part.
        generalised_force : Vector
            Negative derivatives of the total potential energy with respect to the variables.
        """
        return Vector(())

    @property
    def checks_start(self) -> bool:
        """True if the part checks initial states."""
        return type(self).check_start is not Part.check_start

    @of_scalars
    def check_start(self, instant: Instant) -> None:
        """Raise a ValueError for an initial state that the part does not allow. By default every state is allowed."""


NOTHING = Vector((Vector((0.0, 0.0, 0.0)),) * 3)


def parts_of(record: Any) -> Iterator[Part]:
    """Yield the parts in a record, itself included, in the order of its fields."""
    if isinstance(record, Part):
        yield record
    for inner in record.records:
        yield from parts_of(inner)


def jumps_at(parts: Iterable[Any], times: ArrayLike, members: Members = slice(None)) -> dict[str, NDArray[np.bool_]]:
    """Return by the names of parts that jump whether they do so at times, of some members."""
    each = ((part.name, part.jump) for part in parts)
    return {name: members_of(jump, members).falls_on(times) for name, jump in each if jump is not None}


def named_parts(forces: Iterable[Force]) -> dict[str, Part]:
    """Return the parts among forces and within them by name: one that several forces know is one."""
    found: dict[str, Part] = {}
    for part in (part for force in forces for part in parts_of(force)):
        found.setdefault(part.name, part)
    return found


class CompositeBody(Body):
    """A body with its parts at one instant: what formulas see as the body.

    `moments` are those of the body with its parts locked; momentum, rate, energy and the moment about a direction are
    those of all together.
    """

    if TYPE_CHECKING:
        locked: Body
        inside: Sequence[Part]
        values: Mapping[str, Vector]
        time: Scalar

    @classmethod
    def of(cls, body: Body, parts: Sequence[Part], values: Mapping[str, Vector], time: Scalar) -> CompositeBody:
        """Return a body with parts whose variables have values, by the name of the part."""
        own = {"moments": body.moments, "semiaxes": body.semiaxes, "shape": body.shape}
        return cls.unchecked(**own, locked=body, inside=tuple(parts), values=values, time=time)

    def _each(self) -> Iterator[tuple[Part, Vector]]:
        return ((part, self.values[part.name]) for part in self.inside)

    @cached_property
    def change(self) -> Matrix:
        """Sum of the changes of the inertia on which gravity acts."""
        return _sum(part.inertia(own, self.time) for part, own in self._each())

    @cached_property
    def inverse(self) -> Matrix:
        """K^-1."""
        return self.tensor() - _sum(part.spinning_inertia(own) for part, own in self._each())

    @cached_property
    def momentum(self) -> Vector:
        """The sum h of the momenta of the parts at omega = 0."""
        return sum((Vector(part.momentum(own, self.time)) for part, own in self._each()), start=NOTHING[0])

    @override
    def tensor(self) -> Matrix:
        return self.locked.tensor() + self.change

    @property
    @override
    def moves_center_of_mass(self) -> bool:
        return any(part.moves_center_of_mass for part in self.inside)

    @property
    @override
    def inertia(self) -> NDArray[np.float64]:
        return tensor_array(self.tensor())

    @override
    def own(self, block: Block) -> Vector:
        if block.name not in self.values:
            raise KeyError(f"block must be a part of the system, {', '.join(self.values)}, got {quoted(block.name)}.")
        return self.values[block.name]

    @override
    def kinetics(self, scale: Scalar = 1) -> Any:
        return CompositeKinetics(self.inverse, self.momentum, scale)

    @override
    def kinetic_energy(self, angular_momentum_body: ArrayLike) -> Scalar:
        """Return (g - h) . omega / 2 and the internal energies of the parts."""
        internal = sum(part.internal_energy(own, self.time) for part, own in self._each())
        return super().kinetic_energy(angular_momentum_body) + internal

    @override
    def angular_momentum(self, omega_body: ArrayLike) -> Any:
        return product(self.inverse, components(omega_body)) + self.momentum

    @override
    def moment_about(self, direction_body: ArrayLike) -> Scalar:
        direction = Vector(components(direction_body))
        return self.locked.moment_about(direction) + functions.dot(direction, product(self.change, direction))

    @override
    def attracted_moment(self, direction_body: ArrayLike) -> Scalar:
        trace = sum(self.change[i][i] for i in range(3))
        square = functions.dot(components(direction_body), components(direction_body))
        moment: Scalar = self.moment_about(direction_body) - trace * square / 3
        return moment


def _sum(matrices: Iterable[Matrix]) -> Matrix:
    return sum((Vector(map(Vector, matrix)) for matrix in matrices), start=NOTHING)


def tensor_array(matrix: Matrix) -> NDArray[np.float64]:
    """Return rows of numbers or arrays as an array (..., 3, 3)."""
    scalars = np.broadcast_arrays(*(x for row in matrix for x in row))
    return np.stack(scalars, axis=-1).reshape(*scalars[0].shape, 3, 3)


def check_parts(body: Body, forces: Sequence[Force]) -> None:
    """Raise an error if formulas of parts do not return what they must, or if parts do not go together in the body."""
    parts = named_parts(forces)
    names = [force.name for force in forces if isinstance(force, Part)]
    twice = [name for i, name in enumerate(names) if name in names[:i]]
    twice += [part.name for force in forces for part in parts_of(force) if not same(part, parts[part.name])]
    if twice:
        raise ValueError(
            f"the parts of a system must have different names, got two named {quoted(twice[0])}. Give name=."
        )
    _check_together(body, list(parts.values()))


def _check_together(body: Body, parts: Sequence[Part]) -> None:
    movers = [type(part).__name__ for part in parts if part.moves_center_of_mass]
    if len(movers) > 1:
        raise ValueError(
            f"a system must have at most one part that moves the centre of mass, got {' and '.join(movers)}. "
            "Such masses act on each other: write them as one part."
        )
    for part in parts:
        _check_shapes(part)
    if parts:
        _check_inertia(body, parts)


def _check_shapes(part: Part) -> None:
    part = part.with_numbers(part.numbers)
    own, name = part.start(0.0, NOTHING[0]), type(part).__name__
    vectors: dict[str, tuple[Sequence[Scalar], int]] = {
        "start": (own, part.size),
        "momentum": (part.momentum(own, 0.0), 3),
    }
    rows = {"inertia": part.inertia(own, 0.0), "spinning inertia": part.spinning_inertia(own)}
    vectors |= {f"{what}": (tuple(x for row in matrix for x in row), 9) for what, matrix in rows.items()}
    for what, (value, count) in vectors.items():
        if len(value) != count:
            raise TypeError(f"the {what} of {name} must be {count} scalars, got {len(value)}.")


def _check_inertia(body: Body, parts: Sequence[Part]) -> None:
    """Refuse parts that spin more inertia than the body has."""
    body, parts = (body.with_numbers(body.numbers), [part.with_numbers(part.numbers) for part in parts])
    own = {part.name: part.start(0.0, NOTHING[0]) for part in parts}
    least = float(np.min(np.linalg.eigvalsh(tensor_array(CompositeBody.of(body, parts, own, 0.0).inverse))))
    if least <= 0:
        raise ValueError(
            f"parts must have less inertia than the body with its parts locked, but {least:.3g} is left about an axis. "
            "The body's tensor includes them."
        )
