"""Andoyer's variables: the momentum's size and directions as canonical variables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from typing_extensions import override

from poinsot.algebra import quaternion as quat
from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted
from poinsot.errors import member_array, refuse_other_members
from poinsot.kinematics import euler
from poinsot.kinematics.state import State, state_with
from poinsot.printable import described
from poinsot.quantities import Quantity, Times, annotated_with

__all__ = ["Andoyer"]

MOMENTUM_TOLERANCE = 1e-12
"""Largest excess of |L| and |H| over G by rounding, relative to G."""


@dataclass(frozen=True, repr=False, eq=False)
class Andoyer(Summarized):
    """Andoyer variables: three angles and their conjugate momenta, of one state or of the members of an ensemble.

    The attitude is R3(h) R1(I) R3(g) R1(J) R3(l) with cos I = H/G and cos J = L/G. These rotations lead from the space
    axes through the plane normal to the angular momentum to the body axes. If I or J is zero, only the sum of the
    adjacent angles is defined, and the outer angle is zero. Values of I or J below 1e-8 cannot be distinguished from
    zero (Andoyer 1923; Deprit 1967, Am. J. Phys. 35, 424).

    Parameters
    ----------
    l, g, h : float or array (members,)
        Angles in radians.
    L, G, H : float or array (members,)
        Component of the angular momentum along the third body axis, its magnitude, and its component along the third
        space axis.

    Raises
    ------
    ValueError
        If G is not positive, |L| or |H| is larger than G, or the numbers of members differ.

    Examples
    --------
    >>> variables = pt.Andoyer(l=0.1, g=0.2, h=0.3, L=0.5, G=1.0, H=0.4)
    >>> variables.state().angular_momentum_space.round(3)
    array([ 0.271, -0.876,  0.4  ])
    """

    l: Annotated[Any, Quantity("angle")]
    g: Annotated[Any, Quantity("angle")]
    h: Annotated[Any, Quantity("angle")]
    L: Any
    G: Any
    H: Any

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        members = f" of {np.size(self.G)} members" if np.ndim(self.G) else ""
        angles = {name: formatted(getattr(self, name), "rad") for name in ("l", "g", "h")}
        return f"Andoyer's variables{members}", {
            **angles,
            **{name: formatted(getattr(self, name)) for name in ("L", "G", "H")},
        }

    def __post_init__(self) -> None:
        measured = annotated_with(type(self), Quantity)
        for name in ("l", "g", "h", "L", "G", "H"):
            value = getattr(self, name)
            value = member_array(name, measured[name](name, value) if name in measured else value, ())
            object.__setattr__(self, name, value if value.ndim else float(value))
        refuse_other_members(**{name: np.shape(x) for name, x in vars(self).items()})
        if not np.all(self.G > 0):
            raise ValueError(f"G must be positive, got {np.min(self.G)}. A body at rest has no such variables.")
        for name in ("L", "H"):
            excess = np.max(np.abs(getattr(self, name)) / self.G)
            if excess > 1 + MOMENTUM_TOLERANCE:
                raise ValueError(f"{name} must lie between -G and G, got |{name}| = {excess:.13g} G.")

    @classmethod
    @checked
    def from_state(cls, state: State) -> Andoyer:
        """Return the Andoyer variables of a state, with angles in (-pi, pi]."""
        if not isinstance(state, State):
            raise TypeError(f"state must be a State, got {described(state)}.")
        body, space = state.angular_momentum_body, state.angular_momentum_space
        l, h = _azimuth(body[..., 0], body[..., 1]), _azimuth(space[..., 0], -space[..., 1])
        J, I = (np.arctan2(np.hypot(x[..., 0], x[..., 1]), x[..., 2]) for x in (body, space))
        outer, inner = _turn(h, I, 0.0), _turn(0.0, J, l)
        middle = quat.product(quat.product(quat.conjugate(outer), state.quaternion), quat.conjugate(inner))
        g = 2 * np.arctan2(middle[..., 3], middle[..., 0])
        return cls(l, np.arctan2(np.sin(g), np.cos(g)), h, body[..., 2], np.hypot.reduce(body, axis=-1), space[..., 2])

    def state(self, time: Times = 0.0) -> State:
        """Return the state with these variables."""
        (cos_J, sin_J), (cos_I, sin_I) = (_cosine_and_sine(x, self.G) for x in (self.L, self.H))
        J, I = np.arctan2(sin_J, cos_J), np.arctan2(sin_I, cos_I)
        q = quat.product(_turn(self.h, I, self.g), _turn(0.0, J, self.l))
        body = np.stack(np.broadcast_arrays(sin_J * np.sin(self.l), sin_J * np.cos(self.l), cos_J), axis=-1)
        return state_with(q, np.asarray(self.G)[..., None] * body, time)


def _turn(first: Any, second: Any, third: Any) -> Any:
    angles = np.stack(np.broadcast_arrays(first, second, third), axis=-1)
    return euler.quaternion_from_angles(angles, "313")


def _azimuth(sine: Any, cosine: Any) -> Any:
    return np.arctan2(sine + 0.0, cosine + 0.0)  # of signless zeros: zero where both are


def _cosine_and_sine(component: Any, size: Any) -> tuple[Any, Any]:
    sine = np.sqrt(np.maximum((size - component) * (size + component), 0.0)) / size
    return component / size, sine
