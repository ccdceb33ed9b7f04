"""Every public function of analyses and plots takes two bodies, or refuses them in a sentence."""

import inspect
from typing import Any, cast

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes

import poinsot as pt

mpl.use("Agg")

PAIR: Any = pt.TwoBodies(pt.Body((2.0, 2.5, 3.0), mass=3.0), pt.Body((0.1, 0.12, 0.15), mass=0.5), G=1.0)
SYSTEM = pt.System(PAIR, pt.forces.MutualGravity())
SPINS = [(0.1, 0.2, 1.0), (0.0, 0.1, 0.4)]
START = PAIR.state((4.0, 1.0, 2.0), (-0.1, 0.6, 0.3), [(1, 0, 0, 0)] * 2, omega_body=SPINS)
TIMES = np.linspace(0, 8, 200)
MOTION: Any = pt.propagate(SYSTEM, START, TIMES, dense=True)
ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)
analysis, plot = pt.analysis, pt.plot
SOLID, FAR = pt.shapes.Ellipsoid((3, 2, 1), mass=1.0), pt.orbits.FixedPosition(1.0, position=(1e6, 2e6, 0))
LAW = pt.observables.LommelSeeliger(albedo=0.2)
APART = {"shadows": False, "light_time": False}
CURVE = pt.observables.LightCurve((SOLID, SOLID), LAW, FAR, FAR, kind="relative", **APART)


def _place(at: Any) -> tuple[Any, Any]:
    return at.states.position[:, 0], at.states.position[:, 1]


def _spectrum() -> Any:
    with pytest.warns(UserWarning, match=r"^frequencies should be resolved"):  # less than one revolution
        return analysis.frequencies(MOTION.distance, TIMES, 2)


def _precession() -> Any:
    with pytest.warns(UserWarning, match=r"^apsidal_precession should be resolved"):
        return analysis.apsidal_precession(MOTION)


TAKEN: dict[str, Any] = {
    "chaos_indicators": lambda: analysis.chaos_indicators(SYSTEM, START, [8.0]),
    "lyapunov_spectrum": lambda: analysis.lyapunov_spectrum(SYSTEM, START, [8.0]),
    "state_transition": lambda: analysis.state_transition(SYSTEM, START, [8.0]),
    "periodic_motion": lambda: analysis.periodic_motion(SYSTEM, TAKEN["pair_equilibria"]()[0].state, 5.0),
    "frequencies": _spectrum,
    "diffusion": lambda: analysis.diffusion(MOTION.distance, TIMES),
    "section": lambda: analysis.section(MOTION, _place),
    "apsidal_precession": _precession,
    "pair_equilibria": lambda: analysis.pair_equilibria(SYSTEM, PAIR.doubly_synchronous(distance=9.0)),
    "librations": lambda: analysis.librations(MOTION),
    "revolutions": lambda: analysis.revolutions(MOTION),
    "observed_partials": lambda: analysis.observed_partials(SYSTEM, START, CURVE, [8.0]),
    "identify_lines": lambda: analysis.identify_lines(TAKEN["frequencies"](), base=(1.0, 0.3)),
    "plot.readings": lambda: plot.readings(pt.observe(MOTION, CURVE)),
    "plot.phased": lambda: plot.phased(pt.observe(MOTION, CURVE), 5.0),
    "plot.phase_plane": lambda: plot.phase_plane(pt.observe(MOTION, CURVE), (5.0, 6.0)),
    "estimate_run": lambda: analysis.estimate_run(SYSTEM, START, [8.0]),
    "plot.angular_velocity": lambda: plot.angular_velocity(MOTION),
    "plot.difference": lambda: plot.difference(MOTION, MOTION),
    "plot.distance": lambda: plot.distance(MOTION),
    "plot.mutual_orbit": lambda: plot.mutual_orbit(MOTION),
    "plot.drift": lambda: plot.drift(MOTION),
    "plot.chaos": lambda: plot.chaos(analysis.chaos_indicators(SYSTEM, START, TIMES[1:])),
    "plot.uncertainty": lambda: plot.uncertainty(TAKEN["state_transition"](), np.eye(18)),
    "plot.section": lambda: plot.section(TAKEN["section"]()),
    "plot.spectrum": lambda: plot.spectrum(TAKEN["frequencies"]()),
    "view": lambda: pt.view(MOTION, "page.html"),
    "plot.librations": lambda: plot.librations(MOTION),
    "plot.map": lambda: plot.map([1, 2], [1, 2], np.ones(4), "x", "y", "z"),
}
ONE = r"must be of one body, got two bodies\. Take motion\.primary or motion\.secondary\."
OTHERS = r"must be a System of one body, got one of two bodies\. These have"
REFUSED: dict[str, tuple[Any, str]] = {
    "equilibria": (lambda: analysis.equilibria(SYSTEM), OTHERS),
    "equilibria of one of two": (lambda: analysis.equilibria(MOTION.secondary.system), OTHERS),
    "spin_orbit_section": (lambda: analysis.spin_orbit_section(SYSTEM, 0.1, 1.0, 3), OTHERS),
    "andoyer_section": (lambda: analysis.andoyer_section(SYSTEM, START, 8.0), OTHERS),
    "continue_motion": (lambda: analysis.continue_motion(MOTION, "G", 2.0), "must be a PeriodicMotion"),
    "cassini_state": (lambda: analysis.cassini_state(PAIR, ORBIT), "body must be a Body, got TwoBodies"),
    "plot.branch": (lambda: cast("Any", plot.branch)(MOTION, float, ("", "")), "must be a Branch"),
    "plot.sky": (lambda: plot.sky(MOTION, CURVE), ONE),
    "plot.part_variables": (lambda: plot.part_variables(MOTION), ONE),
    "plot.torques": (lambda: plot.torques(MOTION), ONE),
    "plot.attitude_error": (lambda: plot.attitude_error(MOTION, MOTION), ONE),
    "plot.histogram": (lambda: plot.histogram(MOTION), ONE.replace("motion", "ensemble")),
    "plot.roll_pitch_yaw": (lambda: plot.roll_pitch_yaw(MOTION, ORBIT), ONE),
    "free_motion": (lambda: pt.free_motion(PAIR, START, TIMES), "body must be a Body, got TwoBodies"),
} | {
    f"plot.{name}": (lambda name=name: getattr(plot, name)(MOTION), ONE)
    for name in (
        *("angular_momentum", "euler_angles", "quaternions"),
        *("herpolhode", "momentum_sphere", "poinsot_construction", "polhode"),
    )
}
FUNCTIONS = [name for name in analysis.__all__ if inspect.isfunction(getattr(analysis, name))]
FUNCTIONS += [f"plot.{name}" for name in plot.__all__] + ["free_motion", "view"]


@pytest.fixture(autouse=True)
def _own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    yield
    plt.close("all")


def test_all_are_in_a_list():
    of_no_motion = {"secular_evolution", "yorp_coefficients", "plot.yorp"}
    assert sorted(FUNCTIONS) == sorted(({*TAKEN, *REFUSED} | of_no_motion) - {"equilibria of one of two"})


@pytest.mark.parametrize("name", TAKEN)
def test_two_bodies_are_taken(name):
    found = TAKEN[name]()
    if isinstance(found, Axes):
        assert found.has_data()


@pytest.mark.parametrize("name", REFUSED)
def test_two_bodies_are_refused_in_a_sentence(name):
    call, sentence = REFUSED[name]
    with pytest.raises((TypeError, ValueError, AttributeError), match=sentence):
        call()


def test_a_section_at_all_times_has_the_points_of_the_motion():
    found = TAKEN["section"]()
    assert np.array_equal(found.x[0], MOTION.position[:, 0])


@pytest.mark.parametrize("run", [pt.propagate, analysis.state_transition, analysis.chaos_indicators])
def test_one_of_two_bodies_does_not_move_alone(run):
    one = MOTION.secondary
    with pytest.raises(
        ValueError, match=r"^system must be the system of both bodies, got .* motion\.system of the pair\.$"
    ):
        run(one.system, one.initial, [8.0])
