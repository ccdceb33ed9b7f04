"""An impact on one of two bodies."""

from __future__ import annotations

from dataclasses import field
from typing import Any

from typing_extensions import override

from poinsot.events.standard_events import AtTime
from poinsot.mechanics.state import State
from poinsot.mechanics.two_bodies import check_name_of_body
from poinsot.printable import quoted
from poinsot.quantities import SpaceVector

__all__ = ["Impact"]

AXES = ("space", "orbit")


class Impact(AtTime):
    """An impulse at a time changes the velocity of one of two bodies: see `TwoBodies.kick`.

    A run backwards adds the change too: take the opposite one to undo an impact.

    Parameters
    ----------
    time : float
    delta_velocity : array (3,), space axes
        Of the body, length over time; along the axes of the orbit with `axes="orbit"`.
    body : {"secondary", "primary"}
    axes : {"space", "orbit"}
        Those of the change; "orbit": radial, transverse, normal.

    Raises
    ------
    ValueError
        If there is no such body or no such axes.

    Examples
    --------
    >>> ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    >>> pair = pt.TwoBodies(ball, ball, G=1.0)
    >>> start = pair.state((2, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1)] * 2)
    >>> impact = pt.events.Impact(np.pi, (0, -0.1, 0), axes="orbit")
    >>> motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, [4.0], events=[impact])
    >>> (motion.energy - motion.system.energy(start)).round(4)  # (0.9^2 - 1) / 4
    array([-0.0475])
    """

    delta_velocity: SpaceVector
    body: str = field(default="secondary", kw_only=True)
    axes: str = field(default="space", kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_name_of_body(self.body)
        if self.axes not in AXES:
            raise ValueError(f"axes must be 'space' or 'orbit', got {quoted(self.axes)}.")

    @override
    def act(self, body: Any, state: Any) -> State:
        frame = "orbit" if self.axes == "orbit" else None
        after: State = body.kick(state, self.delta_velocity, body=self.body, frame=frame)
        return after
