"""Digital controllers: laws evaluated at samples, with constant torque between samples and with sensor models."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from typing_extensions import override

from poinsot.control.sensors import Sensors
from poinsot.errors import refuse_nonpositive
from poinsot.functions import Scalar, Vector
from poinsot.mechanics.force import Torque
from poinsot.mechanics.instant import Instant
from poinsot.mechanics.part import Jump, Part
from poinsot.quantities import Duration, Rule, Time

__all__ = ["Sampled"]


class Sampled(Part, Torque):
    """Digital controller: a control law evaluated at times k period + offset, with constant torque in between.

    An integration that starts at a sample time begins with that sample. Before the first sample the torque is part of
    the initial state, by default zero. The results at a sample time contain the new torque (right-continuous).
    Integrations run forwards only. Any torque can serve as the law. Inside another part, such as reaction wheels, the
    controller acts like any other law.

    Parameters
    ----------
    law : Torque
        Control law to evaluate.
    period : float
        Time between samples, positive.
    offset : float
        Time of one of the samples.
    sensors : Sensors
        Sensor model that supplies attitude and angular velocity to the law. Default: ideal sensors.

    Examples
    --------
    >>> law = pt.control.Sampled(pt.control.RateDamping(2.0, limit=1.0), period=1.0)
    >>> system = pt.System(pt.Body((10, 12, 8)), law)
    >>> start = system.state((1, 0, 0, 0), omega_body=(0.1, 0, 0))
    >>> pt.propagate(system, start, [0.0, 0.5, 1.0, 1.5]).own["sampled"][:, 0].round(4)
    array([-0.2 , -0.2 , -0.16, -0.16])
    """

    law: Torque
    period: Annotated[Duration, Rule(refuse_nonpositive)]
    offset: Time = 0.0
    sensors: Sensors = Sensors()
    variables: ClassVar[Mapping[str, int]] = {"torque": 3}

    @property
    @override
    def jump(self) -> Jump:
        return Jump(self.period, self.offset, *self.sensors.draws)

    @override
    def update(self, instant: Instant, draws: Vector) -> Vector:
        return Vector(self.law.torque(self.sensors.measured(instant, draws)))

    @override
    def rates(self, instant: Instant, generalised_force: Vector) -> Vector:
        return Vector((0.0, 0.0, 0.0))

    @override
    def torque(self, instant: Instant) -> Vector:
        return instant.own(self)

    @override
    def limits(self, instant: Instant, torque: Vector | None = None) -> Mapping[str, Scalar]:
        return self.law.limits(instant, instant.own(self))
