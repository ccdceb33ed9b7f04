"""Every observable of the package: written as a scenario and in files of readings, and made again."""

from typing import Any

import numpy as np
import pytest

import poinsot as pt
from kinds import concrete_subclasses
from kinds.observables import BOX, ELLIPSOID, FAR, OBSERVABLES, STATION, SUN
from poinsot import observables as ob
from poinsot.mechanics.observable import Observable
from poinsot.observables.readings import Readings
from poinsot.scenarios.builder import Parts
from poinsot.scenarios.registry import makers
from poinsot.scenarios.system_text import text_of_observables
from poinsot.subclasses import is_own

PANELS = pt.forces.Facets([2.0, 1 / 3], [(0, 0, 1), (0, 1, 0)], [(0.1, 0, 0), (0, 0.1, 0)])
LAW = ob.LambertLommelSeeliger(c=0.1, a=0.5, d=1 / 3, k=-0.5)
EVERY = OBSERVABLES | {
    "panels": ob.LightCurve(PANELS, ob.Phong(0.2, 0.3, 20.0), SUN, FAR, kind="relative"),
    "pair": ob.LightCurve(
        (ELLIPSOID, BOX), LAW, SUN, STATION, secondary_law=ob.Lambert(0.2), stretch=(1, 2, 1 / 3), shadows=False
    ),
    "of the secondary": ob.Gyro().on("secondary"),
}
CALENDAR = pt.Calendar("2026-11-21T00:00:00", "TDB", "s")


def test_scenarios_name_every_observable():
    own = {cls.__name__ for cls in concrete_subclasses(Observable) if ".observables." in cls.__module__}
    assert {name for name, maker in makers("observable").items() if is_own(maker.call)} == own
    assert own <= {type(each).__name__ for each in EVERY.values()}


def test_all_are_made_again_from_one_text():
    """Orbits and fields that several observables share are written once, and numbers have all digits."""
    text, data = text_of_observables(EVERY, CALENDAR)
    plans = Parts(text, "it", whole=False, data=data).plans(np.zeros(1))
    assert [plan.name for plan in plans] == list(EVERY)
    for plan, observable in zip(plans, EVERY.values(), strict=True):
        assert repr(plan.observable) == repr(observable)
        assert type(plan.observable) is type(observable)
        for one, other in zip(plan.observable.numbers, observable.numbers, strict=True):
            assert np.array_equal(one, other)
    by_name: dict[str, Any] = {plan.name: plan.observable for plan in plans}
    assert by_name["panels"].sun is by_name["pair"].sun
    assert by_name["range"].station is by_name["pair"].observer


@pytest.mark.parametrize("name", EVERY)
def test_readings_come_back_from_every_file(name, tmp_path, rng):
    observable = EVERY[name]
    count = len(observable.components)
    values = rng.normal(size=(3, count) if count else 3)
    if count == 4:
        values /= np.linalg.norm(values, axis=1)[:, None]
    made = Readings(observable, [0.0, 0.5, 1.0], values, name=name, calendar=CALENDAR)
    (stored,) = pt.files.read_readings(pt.files.write_readings(made, tmp_path / "a.nc"))
    table = pt.files.read_readings_csv(pt.files.write_readings_csv(made, tmp_path / "a.csv"), observable)
    for back in (stored, table):
        assert repr(back.observable) == repr(observable)
        assert np.array_equal(back.values, made.values)
        assert np.array_equal(back.times, made.times)
        assert (back.sigma is None) == (made.sigma is None)
        assert made.sigma is None or np.array_equal(back.sigma, np.broadcast_to(made.sigma, back.sigma.shape))
        assert back.calendar == CALENDAR


def test_outlines_are_single_or_several():
    text = """
    [body]
    moments = [1, 1, 1]
    [orbits.SUN]
    type = "FixedPosition"
    mu = 1.0
    position = [1.5e8, 0, 0]
    [[observe]]
    type = "LightCurve"
    sun = "SUN"
    observer = "SUN"
    law = { type = "Lambert", albedo = 0.2 }
    shadows = "none"
    shape = """
    sphere = '{ type = "Ellipsoid", semiaxes = [1, 1, 1], density = 2e12 }'
    for shape, count in ((sphere, 1), (f"[{sphere}]", 1), (f"[{sphere}, {sphere}]", 2)):
        (plan,) = Parts(text + shape, "it", whole=False).plans(np.zeros(1))
        curve: Any = plan.observable
        assert len(curve.shape.each) == count
    with pytest.raises(ValueError, match=r"observe\[0\]\.shape\.type must name a known type, got 'Elipsoid'\. Did you"):
        Parts(text + sphere.replace("Ell", "El"), "it", whole=False)
    with pytest.raises(
        ValueError, match=r"unknown key 'semiaxis' in \[observe\[0\]\.shape\]\. Did you mean 'semiaxes'"
    ):
        Parts(text + sphere.replace("semiaxes", "semiaxis"), "it", whole=False)
    with pytest.raises(ValueError, match=r"observe\[0\]\.law\.type must name a known type, got 'Lambda'"):
        Parts(text.replace('"Lambert"', '"Lambda"') + sphere, "it", whole=False)
