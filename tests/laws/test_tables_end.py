"""Every table refuses a time outside of its span: at a state and for members, as in a run."""

import numpy as np
import pytest

import poinsot as pt
from kinds import concrete_subclasses
from poinsot.records.parameters import Table

BODY = pt.Body((1.0, 1.4, 2.1))
CALENDAR = pt.Calendar("2026-01-01T00:00:00", "TT")
CIRCLE = pt.KeplerOrbit(3.986e14, semimajor_axis=6.9e6, eccentricity=0.0, inclination=1.4)
FAR = pt.orbits.FixedPosition(398600.4, position=(6871.2, 0, 0))
TIMES = np.linspace(0, 1000, 21)


def tabulated_air():
    air = pt.forces.TabulatedAtmosphere.from_table(TIMES, 1e-12 * np.exp(TIMES / 500))
    facets = pt.forces.Facets.from_box((1, 2, 3), position=(0.1, 0.2, 0.3))
    return pt.forces.AtmosphericDrag(CIRCLE, air, facets), air, "table of densities"


def ephemeris():
    places = lambda times: np.transpose(CIRCLE.position_at(times))  # noqa: E731
    orbit = pt.orbits.Ephemeris.from_function(3.986e14, position=places, start=0.0, stop=1000.0)
    return pt.GravityGradient(orbit), orbit, "ephemeris"


def igrf():
    field = pt.forces.IGRF(FAR, pt.orbits.RotationModel.iau("earth", calendar=CALENDAR), degree=2)
    return pt.forces.MagneticMoment((0.1, 0.2, 0.3), field), field, "IGRF"


TABLES = {"_Rows": tabulated_air, "_Pieces": ephemeris, "_Epochs": igrf}


def test_every_table_is_here():
    assert {kind.__name__ for kind in concrete_subclasses(Table)} == TABLES.keys()


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("way", ["torque_body", "torques_body"])
def test_a_state_outside_of_a_table_is_refused(name, way):
    force, dated, title = TABLES[name]()
    system, (first, last) = pt.System(BODY, force), dated.span
    q, omega = (0.5, 0.5, 0.5, 0.5), (0.1, 0.2, 0.3)
    ask = getattr(system, way)
    for inside in (first, 0.5 * (first + last), last):
        found = ask(BODY.state(q, omega_body=omega, time=inside))
        values = found if way == "torque_body" else sum(found.values())
        assert np.all(np.isfinite(values))
        assert np.any(values)
    for outside in (first - 1e-3 * (last - first), last + 1e-3 * (last - first)):
        message = f"time must lie within the span of the {title}, [{first!r}, {last!r}], got {outside!r}."
        for time in (outside, [first, outside, last]):
            with pytest.raises(ValueError, match=r"^time must lie within") as caught:
                ask(BODY.state(q, omega_body=[omega] * np.size(time) if np.ndim(time) else omega, time=time))
            assert str(caught.value) == message
        with pytest.raises(ValueError, match="must lie within the span of orbits, fields and tables"):
            pt.propagate(system, BODY.state(q, omega_body=omega, time=first), [outside])
