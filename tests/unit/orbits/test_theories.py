"""Tables of VSOP2013 and ELP2000-82B against heyoka's formulas, from which they are made."""

from pathlib import Path

import numpy as np
import pytest

import poinsot.orbits.theories
from poinsot.orbits.theories import moon_position, planet_position

TABLES = Path(poinsot.orbits.theories.__file__).with_suffix(".npz")

AU = 149597870.7
JULIAN_CENTURY = 36525 * 86400.0
LIMIT = 60 * JULIAN_CENTURY  # of planet_orbit, from J2000

NUMBERS = ("mercury", "venus", "earth", "mars", "jupiter", "saturn", "uranus", "neptune", "pluto")
THRESHOLDS = (1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-8, 1e-8, 1e-8, 1e-7)

SECONDS = np.array([-1.8e11, -4.321e8, 8.5e8, 1.85e11])  # about the years -3704, 1986, 2026 and 7862

# Positions at these times by heyoka 7.13.2 in extended precision: planets in au, the Moon in km.
POSITIONS = {
    "mercury": (
        (0.12889749105335105, 0.25387127031987056, 0.11758757212925276),
        (0.15775780356054744, -0.3623023017445469, -0.20988694397816657),
        (-0.3682567306902361, -0.21358808778298413, -0.0759348192926924),
        (0.365246857544417, 0.011863280568831399, -0.025073736716621126),
    ),
    "venus": (
        (0.6293428649330847, -0.3232180839246056, -0.17925241792705537),
        (0.013499921584627405, 0.6565402147393707, 0.29448315149879245),
        (-0.16501113261668057, 0.6342425904463728, 0.2958341731025276),
        (-0.463523782469051, -0.5131059738705992, -0.21497496229820795),
    ),
    "earth": (
        (-0.9887035815252351, -0.16297491147324542, -0.07102047645299434),
        (-0.8424889597574236, -0.503579420371132, -0.21834919739178163),
        (0.238469830399121, 0.8769439359089249, 0.3801351859311768),
        (-0.9800179584202264, 0.13305030064811618, 0.06020904303115692),
    ),
    "mars": (
        (-1.2438683199883884, 0.9766539884247205, 0.49148180724248747),
        (-0.6651225709653207, -1.2444338720541632, -0.5527701637390852),
        (-0.7616000076783421, 1.3019909440599626, 0.6177333422440848),
        (0.4004046809317067, -1.2876294201162164, -0.5933927475767716),
    ),
    "jupiter": (
        (-0.19222198648127164, 4.755610945478924, 2.0568656951286988),
        (4.550742287343965, -1.876642105832396, -0.9153026935650652),
        (-3.8691891461513244, 3.3324609459717602, 1.5225673371426167),
        (-2.223071991086056, 4.281218743710741, 1.864003362378255),
    ),
    "saturn": (
        (-9.781932757804599, -1.573245654459629, -0.3188231343529467),
        (-4.132354258567371, -8.464870957227603, -3.3182223207395842),
        (9.158754542982093, 2.1226341314764916, 0.48230075594865385),
        (5.904426512680341, 6.9025744786944125, 2.666422221558891),
    ),
    "uranus": (
        (19.962619339062908, -1.7158377266066316, -1.0698609982336773),
        (-3.327682414760665, -17.280977432551627, -7.521362499617377),
        (8.688302753056163, 15.963030300396408, 6.868383037271532),
        (-10.135460841590762, -14.428668428445144, -6.161581992368145),
    ),
    "neptune": (
        (3.75082330113996, 27.442720110606846, 11.140453381829966),
        (2.2358380181877258, -27.895865459071885, -11.473697140702845),
        (29.8250797882834, 1.750657236119433, -0.025933521533703523),
        (-26.884117589340537, 12.330427524953322, 5.725533140043315),
    ),
    "pluto": (
        (-31.09657769274331, 1.009094172993039, 9.633867883589309),
        (-23.01331497354832, -18.78318362790956, 1.0722999034588632),
        (20.147449012669952, -25.808883321245048, -14.123818310476244),
        (13.435031286370256, 44.32656332037335, 9.89118912000585),
    ),
    "moon": (
        (-367520.5703045524, -11534.400119367096, 1245.3255105986782),
        (-349019.8984875413, -98836.4965896517, -34243.811885332776),
        (-139711.93048522403, -332712.038794037, -181109.85763678586),
        (112650.07712995277, -337450.97012164333, -167478.7857015967),
    ),
}

# Largest distances from heyoka's formulas, au. Amplitudes in the tables are rounded to units that displace a planet by
# at most 5e-16 au and the Moon by 1e-10 km. The bound of the planets is the requirement; the largest distance of 1000
# random times is 1.1e-13 au, for Pluto. The bound of the Moon is three times the largest distance in four such samples.
LARGEST = {"moon": 9e-16} | dict.fromkeys(NUMBERS, 1e-12)


def position(body, seconds):
    return moon_position(seconds) / AU if body == "moon" else planet_position(body, seconds)


@pytest.mark.parametrize("body", POSITIONS)
def test_stored_positions_of_heyoka(body):
    expected = np.transpose(POSITIONS[body]) / (AU if body == "moon" else 1)
    assert np.max(np.linalg.norm(position(body, SECONDS) - expected, axis=0)) < LARGEST[body]


@pytest.mark.slow
@pytest.mark.parametrize("body", POSITIONS)
def test_positions_of_heyoka_over_twelve_thousand_years(body):
    hy = pytest.importorskip("heyoka")
    if np.finfo(np.longdouble).eps > 2e-19:
        pytest.skip("heyoka's phases in double precision have errors of 1e-11 au")
    time = hy.make_vars("T")
    if body == "moon":
        formulas, unit = hy.model.elp2000_cartesian_fk5(time_expr=time, thresh=1e-7), JULIAN_CENTURY
    else:
        number = NUMBERS.index(body)
        formulas = hy.model.vsop2013_cartesian_icrf(number + 1, time_expr=time, thresh=THRESHOLDS[number])[:3]
        unit = 10 * JULIAN_CENTURY
    theory = hy.cfunc(formulas, [time], compact_mode=True, opt_level=0, fp_type=np.longdouble)
    inside = np.random.default_rng(2013).uniform(-LIMIT, LIMIT, 998)
    seconds = np.array([-LIMIT, *inside, LIMIT])
    expected = theory((seconds.astype(np.longdouble) / np.longdouble(unit))[None, :]) / (AU if body == "moon" else 1)
    assert np.max(np.linalg.norm(position(body, seconds) - expected, axis=0)) < LARGEST[body]


@pytest.mark.slow
def test_the_tool_writes_the_tables_of_the_package(tmp_path, monkeypatch):
    pytest.importorskip("heyoka")
    pytest.importorskip("sympy")
    from tools import theories

    monkeypatch.setattr(theories, "TABLES", tmp_path / "theories.npz")
    theories.main()
    stored, written = (np.load(path) for path in (TABLES, theories.TABLES))
    assert set(written) == set(stored)
    for name in stored:
        np.testing.assert_array_equal(written[name], stored[name], strict=True)


def test_tables_have_at_most_half_a_megabyte():
    assert TABLES.stat().st_size < 500_000


@pytest.mark.parametrize("body", ["moon", "uranus"])
def test_positions_do_not_depend_on_the_number_of_times(body):
    seconds = np.linspace(-1e9, 1e9, 137)
    together = position(body, seconds)
    alone = np.concatenate([position(body, seconds[i : i + 1]) for i in range(seconds.size)], axis=1)
    # rounding errors of sines and cosines, which NumPy computes in vectors and for the last times one by one
    np.testing.assert_allclose(together, alone, rtol=0, atol=1e-14 * np.max(np.abs(together)))
    assert position(body, seconds[:0]).shape == (3, 0)


def test_positions_are_smooth_to_rounding():
    start = 1.8e11
    seconds = start + 64.0 * np.arange(-8, 9)  # times without rounding errors
    differences = np.diff(planet_position("mercury", seconds), 4, axis=1)  # of the motion itself: 3e-18 au
    # Fourth differences are up to 16 rounding errors, each of a sum of 310 terms. Phases that were not reduced in two
    # parts would have errors of 1e-11.
    assert np.max(np.abs(differences)) < 16 * 310 * 2.0**-53 * 0.4
