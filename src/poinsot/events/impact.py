"""An impact on one of two bodies."""

from __future__ import annotations

from dataclasses import field
from typing import Any

from typing_extensions import override

from poinsot.events.standard_events import AtTime
from poinsot.kinematics.state import State
from poinsot.mechanics.two_bodies import check_name_of_body
from poinsot.printable import quoted
from poinsot.quantities import SpaceVector

__all__ = ["Impact"]

AXES = ("space", "orbit")


class Impact(AtTime):
    """Impulsive velocity change of one of two bodies at a given time, as in `TwoBodies.kick`.

    A backward integration adds the same change; pass the opposite vector to undo an impact.

    Parameters
    ----------
    delta_velocity : array (3,), space axes
        Change of the body's velocity, in length per time; along the orbital axes if `axes` is "orbit".
    body : {"secondary", "primary"}
        Body whose velocity changes.
    axes : {"space", "orbit"}
        Axes of the change; "orbit" means radial, transverse and normal.
    terminal : bool
        False, because an event that changes the state must not stop the integration.

    Raises
    ------
    ValueError
        If the body or the axes are unknown, or `terminal` is True.

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
