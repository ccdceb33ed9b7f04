"""What holds for every magnetic field that is shipped, and what a system refuses of them."""

import dataclasses
from datetime import date

import mpmath
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from kinds import concrete_subclasses
from kinds.forces import AXES, MAGNETIC_FIELDS
from poinsot.forces import IGRF, MagneticField, MagneticMoment, TiltedDipole
from poinsot.functions import Vector
from poinsot.orbits import FixedPosition, RotationModel

each_field = pytest.mark.parametrize("field", MAGNETIC_FIELDS, ids=lambda field: type(field).__name__)
POSITIONS = np.array([(1.1, -0.3, 0.4), (-0.2, 0.9, -1.3), (0.0, 0.0, 1.2)])
TIME = 0.7
BODY = pt.Body((1.3, 1.0, 0.7))


def test_every_field_is_here():
    assert concrete_subclasses(MagneticField) == {type(field) for field in MAGNETIC_FIELDS} | {IGRF}


@each_field
def test_neither_sources_nor_currents_outside_the_planet(field):
    exact = field.with_numbers(mpmath.mpf(float(x)) for x in field.numbers)
    with mpmath.workdps(40):
        for position in POSITIONS:
            step, x = mpmath.mpf(10) ** -12, [mpmath.mpf(each) for each in position]

            def slopes(k, x=x, step=step):
                ends = [[each + (sign * step if i == k else 0) for i, each in enumerate(x)] for sign in (1, -1)]
                ahead, behind = (list(exact.at(Vector(end), mpmath.mpf(TIME))) for end in ends)
                return [float((a - b) / (2 * step)) for a, b in zip(ahead, behind, strict=True)]

            matrix = np.array([slopes(k) for k in range(3)])
            assert np.max(np.abs(matrix)) > 0.1
            assert abs(np.trace(matrix)) < 1e-13 * np.max(np.abs(matrix))
            assert np.max(np.abs(matrix - matrix.T)) < 1e-13 * np.max(np.abs(matrix))


@each_field
def test_a_field_turns_with_its_planet(field):
    """At places that turn with the planet it has the same components along its axes, but for secular variation."""
    rates = [name for name in ("g_rate", "h_rate") if hasattr(field, name)]
    steady = dataclasses.replace(field, **{name: 0 * getattr(field, name) for name in rates})
    turns = AXES.attitude([0.0, TIME])
    for position in POSITIONS:
        here, there = (
            turn.inv().apply(np.array(list(steady.in_space(Vector(turn.apply(position)), time)), dtype=float))
            for turn, time in zip(turns, (0.0, TIME), strict=True)
        )
        assert np.allclose(here, there, rtol=0, atol=2e-14)
        assert np.allclose(here, np.array(list(steady.at(Vector(position), TIME)), dtype=float), rtol=0, atol=2e-14)


@each_field
def test_along_the_body_it_is_what_the_attitude_makes_of_it(field):
    system = pt.System(BODY, MagneticMoment((0.5, -0.3, 0.7), field))
    q = (0.1, 0.7, -0.5, 0.5)
    state = system.state(q, omega_body=(0, 0, 0), time=TIME)
    in_space = np.array(list(field.in_space(field.orbit.position_at(TIME), TIME)), dtype=float)
    in_body = Rotation.from_quat(q, scalar_first=True).inv().apply(in_space)
    assert np.allclose(system.torque_body(state), np.cross((0.5, -0.3, 0.7), in_body), rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- what is refused, and counted


def test_orbits_and_rotation_models_along_other_axes_or_with_other_calendars():
    calendars = [pt.Calendar(f"{year}-01-01T00:00:00", "TT") for year in (2025, 2026)]

    def system(reference_frame, calendar):
        positions = {"position": lambda t: np.stack([8e3 + 0 * t, t, 0 * t], -1), "start": 0.0, "stop": 9.0}
        labels = {"reference_frame": reference_frame, "calendar": calendar}
        orbit = pt.orbits.Ephemeris.from_function(398600.4, **positions, **labels)
        earth = RotationModel.iau("earth", calendar=calendars[0])
        return pt.System(BODY, MagneticMoment((1, 0, 0), TiltedDipole(orbit, earth, -3e-5, 0, 0, 6371.2)))

    assert system("ICRF", calendars[0]).calendar == calendars[0]
    with pytest.raises(ValueError, match=r"must have one reference frame, got ICRF and TEME"):
        system("TEME", None)
    with pytest.raises(ValueError, match=r"must have one calendar, got Calendar\(zero='202.*Make one"):
        system("ICRF", calendars[1])


def test_a_field_below_its_reference_radius_is_reported_and_counted():
    orbit = FixedPosition(1.0, position=(0, 0, 1.5))
    with pytest.warns(UserWarning, match=r"^TiltedDipole: the periapsis is 0\.5 below the reference radius"):
        below = TiltedDipole(orbit, AXES, 1.0, 0.0, 0.0, 2.0)
    for field, has_warning in ((below, True), (TiltedDipole(orbit, AXES, 1.0, 0.0, 0.0, 1.25), False)):
        system = pt.System(BODY, MagneticMoment((1, 0, 0), field))
        assert system.validity(system.state((1, 0, 0, 0), omega_body=(0, 0, 0))) == {
            "below_reference_radius": has_warning
        }


ORBIT = FixedPosition(398600.4, position=(6871.2, 0, 0))


def test_what_the_igrf_refuses():
    for degree in (0, 14):
        with pytest.raises(ValueError, match=rf"^degree must be from 1 to 13, got {degree}\.$"):
            IGRF(ORBIT, RotationModel.iau("earth"), degree)
    with pytest.raises(ValueError, match=r"^rotation must have a calendar for a field of dates, got none\. "):
        IGRF(ORBIT, AXES, 3)


def test_the_igrf_has_its_years_and_its_unit_of_length():
    pytest.importorskip("ppigrf")
    earth = RotationModel.iau("earth", calendar=pt.Calendar("2029-12-31T00:00:00", "TT"))
    system = pt.System(BODY, MagneticMoment((1, 0, 0), IGRF(ORBIT, earth, 2)))
    start = system.state((1, 0, 0, 0), omega_body=(0, 0, 0))
    assert system.span == (-86400.0 * (date(2029, 12, 31) - date(1900, 1, 1)).days, 86400.0)
    with pytest.raises(ValueError, match=r"^times must lie within the span of .*, got 90000\.0"):
        pt.propagate(system, start, [90000.0])
    with pytest.raises(ValueError, match=r"^orbit must be within 50 radii of the Earth, got 1078\.\d+\. The radius is"):
        IGRF(FixedPosition(3.986e14, position=(6871.2e3, 0, 0)), earth, 2)


def test_bad_numbers_of_torques():
    field = MAGNETIC_FIELDS[0]
    with pytest.raises(ValueError, match=r"^limit must be positive, got 0\.0"):
        pt.forces.BDot(1.0, field, 0.0)
    with pytest.raises(
        ValueError, match=r"^tensor must be symmetric and not negative, got the eigenvalue -2\. It must"
    ):
        pt.forces.EddyCurrents(-2.0, field)
    with pytest.raises(ValueError, match=r"^tensor must be symmetric and not negative, got one that is not symmetric"):
        pt.forces.EddyCurrents([(1, 0.5, 0), (0, 1, 0), (0, 0, 1)], field)
    for dull in (0.0, np.diag([0.0, 0.0, 2.0])):  # no conductor, and a flat plate
        pt.forces.EddyCurrents(dull, field)
    with pytest.raises(ValueError, match=r"^degree must be at least 1, got 0\.$"):
        pt.forces.MagneticHarmonics(ORBIT, AXES, 0, 1.0, [[0.0]], [[0.0]])
