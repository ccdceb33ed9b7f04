"""What turns a body: potentials (one energy formula) and torques (one torque formula).

To add one, inside or outside the package, write a subclass: its fields are its parameters, its one method
its physics. It is frozen and becomes a dataclass by itself.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

from poinsot import functions
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.attitude import Attitude
from poinsot.mechanics.parameters import Parametric
from poinsot.mechanics.sky import Sky

if TYPE_CHECKING:
    from poinsot.mechanics.body import Body

__all__ = ["Potential", "Torque"]


class Force(Parametric, ABC):
    """What a system takes: a potential or a torque."""


class Potential(Force):
    """A conservative effect, by one scalar formula in body-frame vectors; its torque is derived."""

    @abstractmethod
    def energy(self, body: Body, attitude: Attitude, sky: Sky) -> Scalar:
        """Return the potential energy, written with `attitude.to_body(u)` of space vectors u."""


class Torque(Force):
    """An effect that has no potential, by one formula with three body components."""

    @abstractmethod
    def torque(self, body: Body, attitude: Attitude, omega_body: Vector, sky: Sky) -> Any:
        """Return the torque along the body axes, three scalars."""


class _Recorder(Attitude):
    """An attitude that answers every space vector with three new symbols, and remembers which."""

    def __init__(self, attitude: Attitude) -> None:
        super().__init__(attitude.matrix)
        self.seen: list[tuple[Vector, Vector]] = []

    def to_body(self, vector: Any) -> Vector:
        true = super().to_body(vector)
        symbols = functions.Vector(
            functions.symbol_like(self.matrix[0, 0], f"u{len(self.seen)}_{axis}") for axis in "123"
        )
        self.seen.append((symbols, true))
        return symbols

    def to_space(self, vector: Any) -> Vector:
        x = functions.Vector(vector)
        return functions.Vector(functions.dot(self.to_body(unit), x) for unit in ((1, 0, 0), (0, 1, 0), (0, 0, 1)))


def derived_torque(potential: Potential, body: Body, attitude: Attitude, sky: Sky) -> Vector:
    """Return the torque of a potential along the body axes: the sum over u of u_body x dV/du_body.

    A space vector u turns in body axes as u' = u x omega, so that V' = -tau . omega. The derivative is
    symbolic: `attitude` and `sky` hold heyoka or SymPy expressions.
    """
    recorder = _Recorder(attitude)
    energy = potential.energy(body, recorder, sky)
    total = functions.Vector((0.0, 0.0, 0.0))
    for symbols, _ in recorder.seen:
        slope = functions.Vector(functions.derivative(energy, symbol) for symbol in symbols)
        total = total + functions.cross(symbols, slope)
    known = {symbol: value for pair in recorder.seen for symbol, value in zip(*pair, strict=True)}
    return functions.Vector(functions.substitute(component, known) for component in total)
