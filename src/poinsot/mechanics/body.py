"""The rigid body: its moments of inertia, and what they make of an angular momentum."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import InitVar, field
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.algebra.quaternion import assemble
from poinsot.checked import checked
from poinsot.errors import exactly_one, member_array, real_array, real_numbers, refuse_nonpositive, scalar
from poinsot.functions import Scalar
from poinsot.kinematics.attitude import quaternion_from_matrix, rotation, unit_quaternion
from poinsot.mechanics.kinetics import Kinetics, ObliqueKinetics, turned
from poinsot.printable import described, quoted
from poinsot.quantities import AngularVelocities, Real, Times
from poinsot.records.members import Method, of_arrays
from poinsot.records.parameters import Matrix, Parametric, Points, Vector

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from poinsot.kinematics.frame import Frame
    from poinsot.kinematics.state import State
    from poinsot.mechanics.block import Block

__all__ = ["Body", "ObliqueBody", "inertia_of_spread"]

UNITS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

EQUAL_MOMENTS = 64 * np.finfo(float).eps
"""Moments of a tensor that differ by less, relative to the largest, are equal: their axes are free."""

MAX_REFINEMENTS, SMALL_REFINEMENT = 6, 1e-10
"""The most steps that refine principal axes, and the change of a component whose square is below the rounding."""

TRIANGLE_TOLERANCE = 8 * np.finfo(float).eps
"""A flat plate has I1 + I2 = I3; its rounded moments may miss that by a few units in the last place."""


def _of_vectors(name: str) -> Callable[[Method], Method]:
    """Return the mark of a formula whose argument may also be an array of vectors, shape (..., 3)."""
    return of_arrays(real_numbers, native=True, **{name: (3,)})


class Body(Parametric):
    """Rigid body with given principal moments of inertia.

    The angular momentum g and the angular velocity omega obey g = I omega along the body axes.

    Parameters
    ----------
    moments : array (3,) or (members, 3)
        Principal moments of inertia, in any order and in the user's unit of mass times length squared. The body axes
        are the principal axes. `Body.from_inertia` accepts a tensor along other axes.
    mass : float or array (members,), optional
        Mass of the body. `TwoBodies` requires it; the rotation of a single body does not depend on it.

    Raises
    ------
    ValueError
        If a moment or the mass is not positive, or a moment is larger than the sum of the other two.

    Examples
    --------
    >>> body = pt.Body((1.25, 1.0, 0.75))
    >>> body.omega((0.5, 0.0, 1.5))
    array([0.4, 0. , 2. ])
    """

    moments: Vector
    mass: InitVar[Real | None] = field(default=None, kw_only=True)
    shape: ClassVar[Any] = None
    """The shape that the body was made of by `from_shape`."""
    semiaxes: ClassVar[Any] = None
    """Semiaxes, along the body axes, of the ellipsoid that the body was made of."""
    extra_numbers: ClassVar[Mapping[str, tuple[int, ...]]] = {"mass": (), "semiaxes": (3,)}

    def __post_init__(self, mass: Any) -> None:
        super().__post_init__()
        _check_moments(np.asarray(self.moments))
        if mass is not None:
            mass = member_array("mass", mass, ())
            refuse_nonpositive("mass", mass)
        object.__setattr__(self, "mass", mass)

    @property
    @override
    def definition(self) -> tuple[str, dict[str, Any]]:
        (name, fields), mass = super().definition, self.mass  # type: ignore[attr-defined]
        return name, fields if mass is None else fields | {"mass": mass}

    # ------------------------------------------------------------------ momentum and rate

    def kinetics(self, scale: Scalar = 1) -> Kinetics:
        """Return the matrix that multiplies this body's momentum, times a scale, to give its angular velocity."""
        moments = quat.component_product(self.moments, assemble([scale] * 3, self.moments))
        return Kinetics.of(moments, self.member_axis)

    @_of_vectors("angular_momentum_body")
    def omega(self, angular_momentum_body: ArrayLike) -> NDArray[Any]:
        """Return the angular velocity I^-1 g along the body axes, shape (..., 3), from the angular momentum g."""
        return self.kinetics().omega(_three("angular_momentum_body", angular_momentum_body))

    @_of_vectors("angular_momentum_body")
    def kinetic_energy(self, angular_momentum_body: ArrayLike) -> Scalar:
        """Return the kinetic energy of rotation g . omega / 2, eq. (9), shape (...)."""
        return self.kinetics().kinetic_energy(_three("angular_momentum_body", angular_momentum_body))

    @_of_vectors("omega_body")
    def angular_momentum(self, omega_body: AngularVelocities) -> NDArray[Any]:
        """Return the angular momentum I omega along the body axes, shape (..., 3)."""
        return quat.component_product(self.moments, _three("omega_body", omega_body))

    @_of_vectors("direction_body")
    def moment_about(self, direction_body: ArrayLike) -> Scalar:
        """Return the moment of inertia u . I u about a unit vector u along the body axes, shape (...)."""
        direction = _three("direction_body", direction_body)
        moment: Scalar = quat.dot(self.moments, quat.component_product(direction, direction))
        return moment

    @_of_vectors("direction_body")
    def attracted_moment(self, direction_body: ArrayLike) -> Scalar:
        """Return the moment on which gravity gradients act: `moment_about`, of what parts add the deviator alone.

        The field is harmonic, so that a change which is the same about all axes has no energy in it.
        """
        return self.moment_about(direction_body)

    @property
    def moves_center_of_mass(self) -> bool:
        """True if a part moves the centre of mass along the body axes."""
        return False

    def own(self, block: Block) -> functions.Vector:
        """Return the variables of a part of the body."""
        raise KeyError(f"block must be a part of the system, got {quoted(block.name)}. The system has none.")

    # ------------------------------------------------------------------ axes

    @property
    def principal_axes(self) -> Rotation:
        """Rotation from the principal axes to the body axes, right-handed and as near as possible to the identity."""
        return rotation(quaternion_from_matrix(self.principal_matrix))

    @property
    def principal_matrix(self) -> NDArray[np.float64]:
        """Matrix (3, 3) whose columns are the principal axes along the body axes."""
        return np.eye(3)

    @property
    def inertia(self) -> NDArray[np.float64]:
        """Inertia tensor along the body axes, shape (..., 3, 3)."""
        return np.asarray(np.eye(3) * np.asarray(self.moments)[..., None, :])

    def tensor(self) -> functions.Vector:
        """Return the inertia tensor as three rows of scalars of any kind."""
        return functions.Vector(functions.Vector(self.angular_momentum(functions.Vector(unit))) for unit in UNITS)

    # ------------------------------------------------------------------ ways to a body

    @staticmethod
    @checked
    def from_inertia(tensor: Matrix, mass: Real | None = None) -> Body:
        """Return the body with an inertia tensor along arbitrary body axes.

        All vectors of states, forces and results refer to the axes of the tensor.

        Parameters
        ----------
        inertia : array (3, 3)
            Symmetric inertia tensor along the body axes.
        mass : float, optional
            Mass of the body, which `TwoBodies` requires.

        Raises
        ------
        ValueError
            If the tensor is not symmetric to 1e-12 of its largest entry, or no rigid body has this tensor.
        """
        inertia = real_array("tensor", tensor, (3, 3))
        if not np.allclose(inertia, inertia.T, rtol=0, atol=1e-12 * np.max(np.abs(inertia))):
            raise ValueError(
                f"tensor must be symmetric, but it differs from its transpose by "
                f"{np.max(np.abs(inertia - inertia.T)):.3g}."
            )
        inertia = inertia / 2 + inertia.T / 2  # their sum may overflow
        if np.count_nonzero(inertia - np.diag(np.diag(inertia))) == 0:
            return Body(np.diag(inertia), mass=mass)
        moments, axes = _principal(inertia)
        return ObliqueBody(moments, axes, mass=mass)

    @staticmethod
    @checked
    def from_shape(shape: Any) -> Body:
        """Return the body of a shape (`Mesh`, `Ellipsoid`, ...) about its centre of mass, along the axes of the shape.

        `body.shape` contains the shape. Products of inertia below 1.5e-14 of the largest moment are rounding errors and
        become 0.

        Raises
        ------
        ValueError
            If a moment of inertia is zero, as for points along a line.
        """
        if isinstance(shape, type) or not hasattr(shape, "circumscribing_radius"):
            raise TypeError(f"shape must be a shape, such as a Mesh, got {described(shape)}.")
        inertia = shape.inertia
        negligible = np.abs(inertia) <= EQUAL_MOMENTS * np.max(np.diag(inertia))
        body = Body.from_inertia(np.where(negligible & ~np.eye(3, dtype=bool), 0, inertia), shape.mass)
        body._complete(shape=shape, semiaxes=shape.ellipsoid_along_axes)
        return body

    @staticmethod
    @checked
    def from_stokes(
        C20: float,
        C22: float,
        polar_moment_factor: float,
        *,
        C21: float = 0.0,
        S21: float = 0.0,
        S22: float = 0.0,
        mass: float | None = None,
        radius: float = 1.0,
    ) -> Body:
        """Return the body with a gravity field of second degree and a moment of inertia about its third axis.

        With I33 = c: I11 = c + C20 - 2 C22, I22 = c + C20 + 2 C22, I12 = -2 S22, I13 = -C21, I23 = -S21, all times mass
        radius^2 (MacCullagh's formula (19) in spherical harmonics).

        Parameters
        ----------
        C20, C22, C21, S21, S22 : float
            Coefficients along the body axes, not normalised: sqrt(5) (C20), sqrt(5/3) (C21, S21) and sqrt(5/12) (C22,
            S22) times the normalised coefficients. poinsot cannot detect normalised input. J2 is -C20. Principal axes
            with C20 < -2 C22 < 0 give A < B < C, with the long axis on the prime meridian.
        polar_moment_factor : float
            Polar moment factor c = I33 / (mass radius^2), or C / (M R^2) for principal axes. A mean factor m gives c =
            m - 2/3 C20.
        mass, radius : float
            Mass of the body and reference radius of the coefficients. Without a mass, moments are per unit of mass.

        Raises
        ------
        ValueError
            If no rigid body has these moments.
        """
        c20, c22, c21, s21, s22 = _numbers(C20=C20, C22=C22, C21=C21, S21=S21, S22=S22)
        size = _positive("mass", 1.0 if mass is None else mass) * _positive("radius", radius) ** 2
        c = float(_positive("polar_moment_factor", polar_moment_factor))
        i11, i22, i12 = c + c20 - 2 * c22, c + c20 + 2 * c22, -2 * s22
        return Body.from_inertia(size * np.array([(i11, i12, -c21), (i12, i22, -s21), (-c21, -s21, c)]), mass)

    @staticmethod
    @checked
    def from_ratios(
        *,
        alpha: float | None = None,
        beta: float | None = None,
        gamma: float | None = None,
        polar_moment: float = 1.0,
    ) -> Body:
        """Return the body with two of the three ratios between its moments of inertia (A, B, C) along the body axes.

        alpha = (C - B) / A, beta = (C - A) / B and gamma = (B - A) / C are each in [-1, 1]. Two ratios determine the
        third, beta (1 + alpha gamma) = alpha + gamma, and the shape A : B : C = (1 - gamma) : (1 + alpha gamma) : (1 +
        alpha). The polar moment C is the scale. It affects neither a free rotation nor a rotation under gravity
        gradients. Publications give beta and gamma of the Moon.

        Raises
        ------
        ValueError
            If not exactly two ratios are given, or no rigid body has these ratios.
        """
        named = {"alpha": alpha, "beta": beta, "gamma": gamma}
        given = {name: ratio for name, ratio in named.items() if ratio is not None}
        if len(given) != 2:
            raise ValueError(
                f"from_ratios must have exactly two of alpha, beta, gamma, got {' and '.join(given) or 'none'}."
            )
        shape = _shape_of_ratios(**dict(zip(given, _numbers(**given), strict=True)))
        return Body(shape / shape[2] * _positive("polar_moment", polar_moment))

    @staticmethod
    @checked
    def from_ellipsoid(mass: float, semiaxes: ArrayLike) -> Body:
        """Return the homogeneous ellipsoid with semiaxes (a, b, c) along the body axes."""
        axes = _positive("semiaxes", semiaxes, (3,))
        a, b, c = axes**2
        body = Body(_positive("mass", mass) / 5 * np.array([b + c, a + c, a + b]), mass=mass)
        body._complete(semiaxes=axes)
        return body

    @staticmethod
    @checked
    def from_box(mass: float, sides: ArrayLike) -> Body:
        """Return the homogeneous box with full side lengths (a, b, c) along the body axes."""
        a, b, c = _positive("sides", sides, (3,)) ** 2
        return Body(_positive("mass", mass) / 12 * np.array([b + c, a + c, a + b]), mass=mass)

    @staticmethod
    @checked
    def from_cylinder(mass: float, radius: float, height: float) -> Body:
        """Return the homogeneous circular cylinder whose axis is the third body axis."""
        across, along = _positive("radius", radius) ** 2, _positive("height", height) ** 2
        side = across / 4 + along / 12
        return Body(_positive("mass", mass) * np.array([side, side, across / 2]), mass=mass)

    @staticmethod
    @checked
    def from_point_masses(masses: ArrayLike, positions: Points) -> Body:
        """Return the body of point masses, shape (n,), at positions, shape (n, 3), about their centre of mass."""
        m = _positive("masses", masses, (None,))
        if not m.size:
            raise ValueError("masses must not be empty, got shape (0,).")
        x = real_array("positions", positions, (m.size, 3))
        x = x - m @ x / m.sum()
        return Body.from_inertia(inertia_of_spread(np.einsum("n,ni,nj->ij", m, x, x)), m.sum())

    # ------------------------------------------------------------------ states

    @checked
    def state(
        self,
        attitude: Rotation | ArrayLike,
        *,
        omega_body: AngularVelocities | None = None,
        omega_space: AngularVelocities | None = None,
        angular_momentum_body: ArrayLike | None = None,
        angular_momentum_space: ArrayLike | None = None,
        time: Times = 0.0,
        frame: Frame | None = None,
    ) -> State:
        """Return the state of this body with an attitude and exactly one of the four vectors.

        Parameters
        ----------
        attitude : scipy Rotation or array (4,)
            Rotation body -> space, or body -> frame if a frame is given. A quaternion is scalar first.
        omega_body, omega_space, angular_momentum_body, angular_momentum_space : array (3,)
            Inertial angular velocity (radians per unit of time) or angular momentum, along the body or the space axes.
            If a frame is given, the angular velocity relative to the frame, along the body axes (`omega_body`) or the
            axes of the frame (`omega_space`).
        time : float
            Time of the state. `orbit.calendar.time("2026-11-21T00:00:00 UTC")` converts a date.
        frame : Frame, optional
            Moving axes, such as `orbit.frame`.
        """
        from poinsot.kinematics.state import state_with

        given = {
            "omega_body": omega_body,
            "omega_space": omega_space,
            "angular_momentum_body": angular_momentum_body,
            "angular_momentum_space": angular_momentum_space,
        }
        q, name, along_body = started(attitude, given, time, frame)
        g = self.angular_momentum(along_body) if name.startswith("omega") else along_body
        return state_with(q, g, time)


class ObliqueBody(Body):
    """A body whose axes are not its principal axes; made by `Body.from_inertia`.

    `moments` are the principal moments and `axes` the columns of the principal axes in the body axes.
    """

    axes: Annotated[Any, (3, 3)]

    @override
    def kinetics(self, scale: Scalar = 1) -> Kinetics:
        return ObliqueKinetics.unchecked(**vars(super().kinetics(scale)), axes=self.axes)

    @override
    def angular_momentum(self, omega_body: AngularVelocities) -> NDArray[Any]:
        return turned(self.axes, super().angular_momentum(turned(self.axes.T, _three("omega_body", omega_body))))

    @override
    def moment_about(self, direction_body: ArrayLike) -> Scalar:
        return super().moment_about(turned(self.axes.T, _three("direction_body", direction_body)))

    @property
    @override
    def principal_matrix(self) -> NDArray[np.float64]:
        return np.asarray(self.axes)

    @property
    @override
    def inertia(self) -> NDArray[np.float64]:
        axes = np.asarray(self.axes)
        return np.asarray((axes * np.asarray(self.moments)[..., None, :]) @ np.swapaxes(axes, -1, -2))


def started(
    attitude: Rotation | ArrayLike, given: dict[str, Any], time: ArrayLike, frame: Frame | str | None
) -> tuple[NDArray[np.float64], str, NDArray[np.float64]]:
    """Return the quaternion of a start, and the name and the body components of the one vector that is given."""
    from poinsot.kinematics.frame import axes_at, checked_frame

    time = member_array("time", time, ())
    q = unit_quaternion(attitude)
    name, value = exactly_one("state", given)
    if frame is not None and not name.startswith("omega"):
        raise ValueError(f"a rate relative to a frame must be omega_body or omega_space, got {name}.")
    value = member_array(name, value, (3,))
    along_body = quat.rotate(quat.conjugate(q), value) if name.endswith("_space") else value
    if frame is not None:
        axes, turning = axes_at(checked_frame(frame), time)
        q = quat.product(axes, q)
        along_body = along_body + quat.rotate(quat.conjugate(q), turning)
    return q, name, along_body


def inertia_of_spread(spread: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the inertia tensor of second moments, the integral of x x^T over the mass; both (3, 3)."""
    return np.asarray(np.trace(spread) * np.eye(3) - spread)


def _check_moments(moments: NDArray[np.float64]) -> None:
    small, middle, large = np.sort(moments, axis=-1).T
    with np.errstate(over="ignore"):
        broken = large > (small + middle) * (1 + TRIANGLE_TOLERANCE)
    if np.any(broken | (small <= 0)) and moments.shape == (3, 3) and np.array_equal(moments, moments.T):
        raise ValueError("moments must be the three principal ones, got a tensor. Write Body.from_inertia(tensor).")
    refuse_nonpositive("moments", moments)
    if np.any(broken):
        i = np.argmax(np.atleast_1d(broken))
        a, b, c = (float(np.atleast_1d(x)[i]) for x in (large, small, middle))
        raise ValueError(
            f"moments must satisfy the triangle inequality, but {a} > {b} + {c}. No rigid body has these moments."
        )


def _positive(name: str, value: ArrayLike, shape: tuple[int | None, ...] = ()) -> NDArray[np.float64]:
    array = real_array(name, value, shape)
    refuse_nonpositive(name, array)
    return array


def _numbers(**named: Any) -> list[float]:
    return [float(real_array(name, value, ())) for name, value in named.items()]


def _shape_of_ratios(**ratios: float) -> NDArray[np.float64]:
    """Return moments in the proportion that two ratios between them make."""
    for name, ratio in ratios.items():
        if abs(ratio) > 1:
            raise ValueError(f"{name} must lie in [-1, 1], got {ratio}. No rigid body has these moments.")
    (x, y), names = ratios.values(), set(ratios)
    if "alpha" not in names:
        shape = np.array([1 - x * y, 1 + y, 1 + x])
    elif "beta" not in names:
        shape = np.array([1 - y, 1 + x * y, 1 + x])
    else:
        shape = np.array([1 - y, 1 - x, 1 - x * y])
    refuse_nonpositive("moments", shape)
    return shape


def _principal(inertia: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return principal moments and axes (columns), right-handed, nearest to the given axes, each rounded once."""
    moments, axes = np.linalg.eigh(inertia)
    choices = [
        (moments[list(order)], _settled(moments[list(order)], axes[:, order] * signs))
        for order in itertools.permutations(range(3))
        for signs in itertools.product((1, -1), repeat=3)
    ]
    right_handed = (choice for choice in choices if np.linalg.det(choice[1]) > 0)
    return _refined(inertia, *max(right_handed, key=lambda choice: np.trace(choice[1])))


def _refined(
    inertia: NDArray[np.float64], moments: NDArray[np.float64], axes: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the moments and axes of a tensor, corrected in exact arithmetic and rounded at the end.

    Steps of Ogita and Aishima (2018, Japan J. Indust. Appl. Math. 35, 1007, Algorithm 1): X + X E, with
    R = 1 - X^T X, S = X^T A X, E_ij = (S_ij + l_j R_ij) / (l_j - l_i), l_i = S_ii / (1 - R_ii), and E_ij = R_ij / 2 for
    equal moments, whose axes are free. A step squares the error, so that the step after a small one changes nothing.
    """
    exact = np.vectorize(Fraction, otypes=[object])
    tensor, x, equal = exact(inertia), exact(axes), _equal(moments)
    for _ in range(MAX_REFINEMENTS):
        rest, product = exact(np.eye(3)) - x.T @ x, x.T @ tensor @ x
        values = np.diag(product) / (1 - np.diag(rest))
        gaps = np.where(equal, 1, values - values[:, None])
        change = np.where(equal, rest / 2, (product + values * rest) / gaps).astype(float)
        x = x + x @ exact(change)
        if np.max(np.abs(change)) < SMALL_REFINEMENT:
            break
    return values.astype(float), x.astype(float)


def _equal(moments: NDArray[np.float64]) -> NDArray[np.bool_]:
    with np.errstate(over="ignore"):
        return np.asarray(np.abs(moments[:, None] - moments) <= EQUAL_MOMENTS * np.max(moments))


def _settled(moments: NDArray[np.float64], axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the axes, those of equal moments turned among themselves to the nearest ones."""
    equal = _equal(moments)
    out = axes.copy()
    for i in range(3):
        group = np.flatnonzero(equal[i])
        left, _, right = np.linalg.svd(axes[:, group].T @ np.eye(3)[:, group])
        out[:, group] = axes[:, group] @ left @ right
    return out


def _three(name: str, vectors: ArrayLike) -> Any:
    """Return vectors of numbers, shape (..., 3), checked; those of a formula as they are."""
    if isinstance(vectors, functions.Vector):
        return vectors
    if isinstance(vectors, np.ndarray) and vectors.dtype == object:
        return scalar(name, vectors)
    array = real_numbers(name, vectors)
    if array.shape[-1:] != (3,):
        raise ValueError(f"{name} must have shape (..., 3), got shape {array.shape}.")
    return array
