"""What is read from a motion."""

import inspect
import itertools
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from in_order import in_order
from poinsot.checked import checked
from poinsot.propagation.column_reader import MotionRows
from poinsot.propagation.trajectory import OfTwoBodies, is_of_two_bodies, of_one_body

SEQUENCES = [a + b + c for a, b, c in itertools.product("123", repeat=3) if a != b and b != c]
TIMES = np.linspace(-1, 9, 21)
MOMENTS = np.array([1.25, 1.0, 0.75])


@pytest.fixture(scope="module")
def motion(top, start):
    return pt.propagate(top, start, TIMES)


def test_first_axis_is_the_times(motion):
    for name in ("omega_body", "omega_space", "angular_momentum_body", "angular_momentum_space"):
        assert getattr(motion, name).shape == (21, 3)
    for name in ("quaternion", "conjugate_momenta"):
        assert getattr(motion, name).shape == (21, 4)
    for name in ("times", "kinetic_energy", "potential_energy", "energy", "norm_error", "tangency_error"):
        assert getattr(motion, name).shape == (21,)
    assert len(motion.attitude) == 21


def test_a_motion_knows_its_system_and_its_start(motion, top, start):
    assert motion.system is top
    assert motion.initial is start


def test_angular_momentum_and_rates_are_consistent(motion):
    turn = Rotation.from_quat(motion.quaternion, scalar_first=True)
    assert np.allclose(motion.angular_momentum_body, MOMENTS * motion.omega_body, rtol=0, atol=1e-15)
    assert np.allclose(motion.angular_momentum_space, turn.apply(motion.angular_momentum_body), rtol=0, atol=1e-14)
    assert np.allclose(motion.omega_space, turn.apply(motion.omega_body), rtol=0, atol=1e-14)


def test_attitude_is_scipys_body_to_space(motion):
    expected = Rotation.from_quat(motion.quaternion, scalar_first=True)
    assert np.max((expected.inv() * motion.attitude).magnitude()) < 1e-15


def test_rates_are_the_derivative_of_the_attitude(top, start):
    step = 1e-5
    motion = pt.propagate(top, start, [2 - step, 2.0, 2 + step])
    turn = (motion.attitude[2] * motion.attitude[0].inv()).as_rotvec() / (2 * step)
    assert np.allclose(motion.omega_space[1], turn, rtol=0, atol=1e-9)


def test_energies(motion):
    height = motion.attitude.apply([1.0, 0.2, -0.3])[:, 2]
    assert np.allclose(motion.kinetic_energy, 0.5 * np.sum(MOMENTS * motion.omega_body**2, axis=-1), rtol=0, atol=1e-15)
    assert np.allclose(motion.potential_energy, 0.5 * height, rtol=0, atol=1e-14)
    assert np.array_equal(motion.energy, motion.kinetic_energy + motion.potential_energy)


def test_potential_energy_of_a_free_body_is_zero(body, start):
    assert pt.propagate(pt.System(body), start, TIMES).potential_energy.tolist() == [0.0] * 21


def test_rates_and_energies_of_an_oblique_body(start):
    tensor = np.array([[2.0, 0.3, -0.1], [0.3, 3.0, 0.2], [-0.1, 0.2, 2.5]])
    motion = pt.propagate(pt.System(pt.Body.from_inertia(tensor)), start, TIMES)
    assert np.allclose(motion.omega_body @ tensor, motion.angular_momentum_body, rtol=0, atol=1e-14)
    energy = 0.5 * np.sum(motion.omega_body * motion.angular_momentum_body, axis=-1)
    assert np.allclose(motion.kinetic_energy, energy, rtol=1e-14, atol=0)
    assert np.max(np.abs(motion.drift["energy"])) < 1e-14


def test_euler_variables_along_the_way(motion):
    angles, momenta = motion.euler()
    states = [
        pt.State(q, pt.mechanics.project_to_tangent(q, Q)).euler()
        for q, Q in zip(motion.quaternion, motion.conjugate_momenta, strict=True)
    ]
    assert np.allclose(angles, [a for a, _ in states], rtol=0, atol=1e-14)
    assert np.allclose(momenta, [p for _, p in states], rtol=0, atol=1e-14)
    assert motion.euler("321")[0].shape == (21, 3)


@pytest.mark.parametrize("sequence", SEQUENCES)
@pytest.mark.parametrize("members", [0, 3])
def test_angles_at_singular_attitudes_are_nan_with_one_warning(sequence, members):
    """Turns about the second axis, which pass the singular attitudes at the times 0 and pi, or pi/2 and 3 pi/2."""
    body, axis = pt.Body((2.0, 2.0, 2.0)), np.eye(3)[int(sequence[1]) - 1]
    times = np.arange(9) * np.pi / 4
    rates = np.multiply.outer(np.arange(1, members + 1), axis) if members else axis
    start = np.broadcast_to((1.0, 0, 0, 0), (members, 4)) if members else (1.0, 0, 0, 0)
    motion = pt.propagate(pt.System(body), body.state(start, omega_body=rates), times, progress=False)
    middle = np.multiply.outer(np.arange(1, members + 1), times) if members else times
    sine = np.sin(middle) if sequence[0] == sequence[2] else np.cos(middle)
    with pytest.warns(UserWarning, match=rf"^the second angle of sequence {sequence} must stay away") as caught:
        angles, momenta = motion.euler(sequence)
    assert len(caught) == 1
    assert angles.shape == momenta.shape == motion.omega_body.shape
    singular = np.abs(sine) < 1e-9
    assert np.any(singular)
    assert not np.all(singular)
    np.testing.assert_array_equal(np.isnan(angles), np.broadcast_to(singular[..., None], angles.shape))
    np.testing.assert_array_equal(np.isnan(momenta), np.isnan(angles))
    letters = sequence.translate(str.maketrans("123", "XYZ"))
    expected = Rotation.from_euler(letters, angles[~singular])
    seen = Rotation.from_quat(motion.quaternion[~singular], scalar_first=True)
    assert np.max((expected.inv() * seen).magnitude()) < 1e-13
    regular = str(caught[0].message)[-4:-1]
    if regular in SEQUENCES:
        assert np.all(np.isfinite(motion.euler(regular)[0]))


def test_third_space_component_is_the_first_momentum_of_313(motion):
    assert np.allclose(motion.euler("313")[1][:, 0], motion.angular_momentum_space[:, 2], rtol=0, atol=1e-14)


# ---------------------------------------------------------------------- proof


def test_norm_and_tangency_errors_are_measured_not_removed(motion):
    assert np.array_equal(motion.norm_error, np.sqrt(np.sum(motion.quaternion**2, axis=-1)) - 1) or np.allclose(
        motion.norm_error, np.linalg.norm(motion.quaternion, axis=-1) - 1, rtol=0, atol=3e-16
    )
    expected = np.sum(motion.quaternion * motion.conjugate_momenta, axis=-1)
    expected /= np.linalg.norm(motion.conjugate_momenta, axis=-1)
    assert np.allclose(motion.tangency_error, expected, rtol=0, atol=1e-15)
    assert np.max(np.abs(motion.norm_error)) < 1e-14


def test_errors_of_a_pair_in_si_units_are_relative():
    """The momenta of an asteroid and its moon are 1e18 kg m2/s; a relative error is at the level of the rounding."""
    primary = pt.Body.from_ellipsoid(5e11, (400.0, 390.0, 370.0))
    pair = pt.TwoBodies(primary, pt.Body.from_ellipsoid(4e9, (90.0, 70.0, 60.0)), G=6.6743e-11)
    system = pt.System(pair, pt.forces.MutualGravity(), units={"time": "s", "inertia": "kg m2"})
    start = pair.state((1200.0, 0, 0), (0, 0.17, 0), ((1, 0, 0, 0),) * 2, omega_body=[(0, 0, 7e-4), (1e-5, 0, 1.4e-4)])
    motion: Any = pt.propagate(system, start, np.linspace(0, 86400, 5))
    for one in (motion.primary, motion.secondary):
        q, momenta = one.quaternion, one.conjugate_momenta
        expected = np.sum(q * momenta, axis=-1) / np.sqrt(np.sum(momenta**2, axis=-1))
        assert np.allclose(one.tangency_error, expected, rtol=0, atol=1e-15)
    assert np.max(np.abs(motion.primary.conjugate_momenta)) > 1e12
    (line,) = [line for line in repr(motion).splitlines() if "tangency error" in line]
    name, value = line.split(": ")
    assert name == "  tangency error (relative)"
    assert 0 <= float(value) < 1e-13
    assert motion.dataset.tangency_error.units == "1"
    assert motion.dataset.tangency_error.long_name == "q . Q / |Q|"


def test_a_body_without_momentum_has_no_tangency_error():
    body = pt.Body((1.25, 1.0, 0.75))
    motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 0)), [0.0, 1.0])
    assert motion.tangency_error.tolist() == [0.0, 0.0]


def test_norm_error_of_a_state_off_the_sphere_is_seen(top):
    q = np.array([1 + 5e-10, 0, 0, 0])
    motion = pt.propagate(top, pt.State(q, (0, 1, 0, 0)), [0.0, 1.0])
    assert np.allclose(motion.norm_error, 5e-10, rtol=1e-5, atol=0)


def test_integrals_and_their_drift(motion, top):
    assert list(motion.integrals) == list(motion.drift) == ["energy", "angular_momentum_space_3"]
    assert np.allclose(motion.integrals["energy"], motion.energy, rtol=0, atol=1e-15)
    scale = np.max(np.abs(motion.kinetic_energy) + np.abs(motion.potential_energy))
    expected = (motion.energy - top.energy(motion.initial)) / scale
    assert np.allclose(motion.drift["energy"], expected, rtol=0, atol=1e-16)
    momentum = np.max(np.linalg.norm(motion.angular_momentum_body, axis=-1))
    expected = (motion.angular_momentum_space[:, 2] - motion.initial.angular_momentum_space[2]) / momentum
    assert np.allclose(motion.drift["angular_momentum_space_3"], expected, rtol=0, atol=1e-16)


def test_drift_grows_with_the_tolerance(top, start):
    loose, tight = (pt.propagate(top, start, TIMES, tolerance=t).drift["energy"] for t in (1e-4, 1e-12))
    assert np.max(np.abs(loose)) > 100 * np.max(np.abs(tight))


def test_drift_of_a_body_at_rest_is_zero(body):
    motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0, 0, 0)), [0.0, 1.0])
    assert all(drift.tolist() == [0, 0] for drift in motion.drift.values())


def test_no_integrals_no_drift(satellite, start):
    motion = pt.propagate(satellite, start, [0.0, 1.0])
    assert motion.drift == motion.integrals == {}
    assert motion.summary["integrals"] == "none: this system conserves neither energy nor a momentum"


def test_summary_is_one_flat_record(motion):
    summary = motion.summary
    assert summary["method"] == "Taylor"
    assert summary["formulation"] == "lie_poisson"
    assert summary["steps"] == motion.run.steps
    assert summary["tolerance"] == motion.run.tolerance
    assert summary["norm_error"] == np.max(np.abs(motion.norm_error))
    assert summary["drift_energy"] == np.max(np.abs(motion.drift["energy"]))
    assert "drift_angular_momentum_space_3" in summary
    assert all(isinstance(value, str | int | float) for value in summary.values())


def test_repr_says_what_ran_and_how_well(motion):
    lines = repr(motion).splitlines()
    assert lines[0].startswith("Trajectory of System(Body(")
    assert lines[1] == "  times: 21, -1 ... 9"
    assert lines[2].startswith(f"  method: Taylor, order 20, {motion.run.steps} steps, tolerance 2.22e-16")
    for word in ("variables: lie_poisson, double precision", "norm error: ", "drift: energy "):
        assert any(line.strip().startswith(word) for line in lines)


# ---------------------------------------------------------------------- members and times

ORBITS = in_order(pt.KeplerOrbit, 2.0, 1.5, [0.1, 0.3, 0.6], 0.4, 1.1, -0.7, [2.0, 1.0, 0.0])
OBLIQUE = pt.Body.from_inertia([[2.0, 0.3, -0.1], [0.3, 3.0, 0.2], [-0.1, 0.2, 2.5]])


class Pushed(pt.Torque):
    """A torque of a class that no file knows."""

    size: float

    def torque(self, instant):
        return pt.functions.Vector((self.size, 0.0, -0.3 * instant.omega_body[2]))


ENSEMBLES = {
    "orbits of their own": (pt.System(pt.Body((1.0, 1.3, 1.6)), pt.GravityGradient(ORBITS)), 0.0),
    "moments and starts of their own": (pt.System(pt.Body([(1, 2, 2.5), (2, 2, 3), (1, 1, 1)])), [0.0, 1.0, -0.5]),
    "one oblique body": (pt.System(OBLIQUE, pt.UniformGravity(0.5, (1.0, 0.2, -0.3))), 0.0),
    "stored without forces": (pt.System(OBLIQUE, Pushed([0.1, 0.2, 0.3])), 0.0),
    "parts of their own": (
        pt.System(
            pt.Body((2.0, 2.3, 2.6)),
            pt.parts.ReactionWheel((0, 0, 1), [0.1, 0.2, 0.3], friction=0.01),
            pt.parts.KaneDamper(0.2, [0.1, 0.0, 0.3]),
        ),
        0.0,
    ),
}


@pytest.fixture(scope="module", params=ENSEMBLES)
def members(request):
    system, time = ENSEMBLES[request.param]
    quaternions = [(0.1, 0.7, -0.5, 0.5), (0.5, -0.5, 0.5, 0.5), (1, 0, 0, 0)]
    start = system.state(quaternions, omega_body=0.3 * np.eye(3), time=time)
    return pt.propagate(system, start, TIMES)


def read(motion):
    """Everything that is read from a motion, by name."""
    relative = motion.relative_to(pt.RotatingFrame((0.5, 0.5, 0.5, 0.5), (0, 0, 0.1)))
    names: tuple[str, ...] = (
        "conjugate_momenta",
        "angular_momentum_body",
        "angular_momentum_space",
        "omega_body",
        "omega_space",
    )
    names += ("kinetic_energy", "potential_energy", "energy", "norm_error", "tangency_error", "quaternion")
    found = {name: getattr(motion, name) for name in names} | {"relative": relative.omega_body}
    found |= {f"own {name}": values for name, values in motion.own.items()}
    found |= {f"integral {name}": values for name, values in motion.integrals.items()}
    return found | {f"drift {name}": values for name, values in motion.drift.items()}


def assert_same(values, rows, name):
    """Bit for bit; what orbits give is computed again, by sines of arrays of another shape: some ulps of energies."""
    slack = (
        0.0
        if name not in ("potential_energy", "energy")
        else 16 * np.finfo(float).eps * np.max(np.abs(rows), initial=0)
    )
    np.testing.assert_allclose(values, rows, rtol=0, atol=slack, err_msg=name)


def test_a_member_reads_as_its_row_of_the_ensemble(members, tmp_path):
    for motion in (members, pt.load(pt.save(members, tmp_path / "members.nc"))):
        rows = read(motion)
        for i in range(3):
            own = read(motion.member(i))
            for name, values in rows.items():  # it may conserve more than the ensemble does
                assert_same(own[name], values[i], name)
            np.testing.assert_array_equal(motion.member(i).times, TIMES)


def test_a_member_is_saved_and_loaded(members, tmp_path):
    one = pt.load(pt.save(members, tmp_path / "members.nc")).member(1)
    back = pt.load(pt.save(one, tmp_path / "one.nc"))
    for name, values in read(one).items():
        assert_same(read(back)[name], values, name)
    assert repr(back.system) == repr(one.system)
    assert back.summary["norm_error"] == one.summary["norm_error"] == np.max(np.abs(one.norm_error))


@pytest.mark.parametrize("chosen", [slice(3, 15, 4), [0, 5, -1], TIMES > 5, np.arange(0), slice(None)])
def test_some_of_the_times(members, chosen):
    some, rows = members.isel(time=chosen), read(members)
    assert np.array_equal(some.times, TIMES[chosen])
    for name, values in read(some).items():
        if not name.startswith("drift"):  # which is relative to the largest of its times
            assert_same(values, rows[name][:, chosen], name)
    assert np.array_equal(members.isel(time=chosen, member=2).quaternion, members.quaternion[2, chosen])


def comoving(motion):
    return motion.environment.orbit_values


def test_an_orbit_that_is_integrated_along_goes_with_its_member():
    path = pt.orbits.LagrangePointPath(1.0, 0.01, separation=1.0, point="L4")
    point = path.path(offset=[(0.01, 0, 0), (0, 0.02, 0)]).from_secondary
    system = pt.System(pt.Body((1.0, 1.3, 1.6)), pt.GravityGradient(point))
    start = system.body.state([(1, 0, 0, 0), (0.5, 0.5, 0.5, 0.5)], omega_body=(0, 0, 1))
    motion = pt.propagate(system, start, TIMES, events=[pt.events.Apsis(point)])
    assert comoving(motion).shape[:2] == (2, 21)
    for part, rows in ((motion.member(1), 1), (motion.isel(time=slice(2, 9), member=[1]), (slice(1, 2), slice(2, 9)))):
        assert np.array_equal(part.potential_energy, motion.potential_energy[rows])
        assert np.array_equal(comoving(part), comoving(motion)[rows])


def test_times_of_one_body(top, start):
    motion = pt.propagate(top, start, TIMES, dense=True, events=[pt.events.RateCrossing((0, 0, 1))])
    assert len(motion) == 21
    part = motion[2:20:3]
    assert np.array_equal(part.quaternion, motion.quaternion[2:20:3])
    assert np.array_equal(part(0.123).quaternion, motion(0.123).quaternion)
    assert part.initial is motion.initial
    assert part.events is motion.events
    for state in (motion[-2], motion.isel(time=19)):
        assert state.time == TIMES[19]
        assert np.array_equal(state.quaternion, motion.quaternion[19])
        assert np.array_equal(state.conjugate_momenta, motion.conjugate_momenta[19])
    assert [float(state.time) for state in motion] == TIMES.tolist()


def test_one_time_of_an_ensemble(members):
    state = members.isel(time=4)
    assert np.array_equal(state.angular_momentum_body, members.angular_momentum_body[:, 4])
    assert state.time.tolist() == [TIMES[4]] * 3
    assert np.array_equal(members.isel(time=4, member=1).quaternion, members.quaternion[1, 4])


def test_places_that_are_none(motion, members):
    for call, kind, sentence in (
        (lambda: motion.member(0), ValueError, "motion must be an ensemble to have members, but it is of one body."),
        (lambda: members.member(3), IndexError, r"member must lie within \[-3, 2\], got 3."),
        (lambda: motion[21], IndexError, r"time must lie within \[-21, 20\], got 21."),
        (lambda: motion.isel(time=[3, 2]), ValueError, "time must have the order of the times of the motion, got"),
        (lambda: motion.isel(time=[3, 3]), ValueError, "time must have the order"),
        (lambda: motion.isel(time=1.5), TypeError, "time must be a whole number, a slice, .* 21 truth values, got"),
        (lambda: motion.isel(time=[True, False]), TypeError, "time must be a whole number"),
        (lambda: members["a"], TypeError, "member must be a whole number"),
        (lambda: members[0:"b"], TypeError, "member must be a slice of whole numbers, got"),
        (lambda: members.member(True), TypeError, "member must be a whole number"),
    ):
        with pytest.raises(kind, match=sentence):
            call()


# ---------------------------------------------------------------------- frames


def test_relative_to_a_frame_at_rest_is_the_motion_itself(motion):
    relative = motion.relative_to(pt.RotatingFrame((1, 0, 0, 0), (0, 0, 0)))
    assert np.array_equal(relative.quaternion, motion.quaternion)
    assert np.array_equal(relative.omega_body, motion.omega_body)
    assert np.array_equal(relative.times, motion.times)


def test_relative_rate_is_the_derivative_of_the_relative_attitude(satellite, start):
    step, frame = 1e-5, satellite.forces[0].orbit.frame
    motion = pt.propagate(satellite, start, [2 - step, 2.0, 2 + step])
    relative = motion.relative_to(frame)
    turn = (relative.attitude[0].inv() * relative.attitude[2]).as_rotvec() / (2 * step)
    middle = relative.attitude[0].inv() * relative.attitude[1]
    assert np.allclose(relative.omega_body[1], middle.inv().apply(turn), rtol=0, atol=1e-8)


def test_relative_attitude_is_body_to_frame(satellite, start):
    frame = satellite.forces[0].orbit.frame
    motion = pt.propagate(satellite, start, TIMES)
    expected = frame.attitude(TIMES).inv() * motion.attitude
    assert np.max((expected.inv() * motion.relative_to(frame).attitude).magnitude()) < 2.5e-15


def test_gravity_gradient_equilibrium_stays_in_the_orbit_frame():
    orbit = pt.KeplerOrbit(2.0, semimajor_axis=1.5, eccentricity=0.0, inclination=0.4, node=1.1)
    body = pt.Body((1.0, 1.3, 1.6))
    state = body.state((1, 0, 0, 0), omega_body=(0, 0, 0), frame=orbit.frame)
    motion = pt.propagate(pt.System(body, pt.GravityGradient(orbit)), state, np.linspace(0, orbit.period, 9))
    relative = motion.relative_to(orbit.frame)
    assert np.max(relative.attitude.magnitude()) < 1e-13
    assert np.max(np.abs(relative.omega_body)) < 1e-13


@pytest.mark.parametrize("starts", [(), (3,)], ids=["one", "ensemble"])
def test_drifts_are_relative_to_energy_and_to_momentum(starts):
    """Computed from the columns, for moments and weights far from 1, where the two sizes differ."""
    top = pt.System(pt.Body((9.0, 7.0, 5.0)), pt.UniformGravity(weight=40.0, center_of_mass=(0.5, 0, 0.2)))
    rates = np.random.default_rng(5).normal(size=(*starts, 3))
    motion = pt.propagate(top, top.body.state((1, 0, 0, 0), omega_body=rates), np.linspace(0, 20, 41), tolerance=1e-6)
    energies = np.abs(motion.kinetic_energy) + np.abs(motion.potential_energy)
    momenta = np.linalg.norm(motion.angular_momentum_body, axis=-1)
    drift, sizes = motion.drift, {"energy": energies, "angular_momentum_space_3": momenta}
    assert drift.keys() == sizes.keys()
    for name, size in sizes.items():
        values, largest = motion.integrals[name], size.max(axis=-1, keepdims=True)
        expected = (values - values[..., :1]) / largest
        assert np.max(np.abs(expected)) > 1e-12
        np.testing.assert_allclose(drift[name], expected, rtol=0, atol=8 * np.finfo(float).eps)  # of values near 1


@pytest.mark.parametrize(
    ("names", "kind", "got"),
    [
        (["x"], ValueError, r"names must be some of quaternion, .*, got 'x'\."),
        (["quaternion", 1], ValueError, r"names must be some of quaternion, .*, got 1\."),
        ("quaternion", TypeError, r"names must be a list of names, got str\."),
        (1.0, TypeError, r"names must be a list of names, got float\."),
    ],
)
def test_variables_must_be_names_of_variables(names, kind, got):
    body = pt.Body((1.25, 1.0, 0.75))
    motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), [0.0, 1.0])
    with pytest.raises(kind, match=f"^{got}$"):
        motion.variables(names)


@pytest.mark.parametrize("failures", [np.ones(2), ["late"], 1.0])
def test_failures_must_be_a_mapping(failures):
    body = pt.Body((1.25, 1.0, 0.75))
    motion = pt.propagate(pt.System(body), body.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), [0.0, 1.0])
    with pytest.raises(TypeError) as caught:
        pt.Trajectory(motion.system, motion.initial, motion.times, MotionRows({}), motion.run, failures=failures)
    kind = type(failures).__name__
    assert str(caught.value) == f"failures must be a mapping of members to reasons, got {kind}."


# ---------------------------------------------------------------------- public face


def test_signature_and_names_are_those_that_a_user_reads(motion):
    assert str(inspect.signature(pt.Trajectory)).startswith(
        "(system: 'System', initial: 'AnyState', times: 'Array', rows: "
    )
    assert [*inspect.signature(pt.Trajectory).parameters] == [
        *("system", "initial", "times", "rows", "run", "dense", "failures", "provenance")
    ]
    names = {name for name in dir(motion) if not name.startswith("_")}
    assert {"quaternion", "omega_body", "column", "dataset", "euler", "isel", "torques_body"} <= names
    assert not names & {
        "position",
        "primary",
        "secondary",
        "elements",
        "orbit_frame",
        "event_source",
        "state_variables",
    }
    assert all(inspect.getdoc(getattr(pt.Trajectory, name)) for name in names if hasattr(pt.Trajectory, name))


def test_names_of_a_motion_of_two_bodies():
    ball = pt.Body((0.4, 0.4, 0.4), mass=1.0)
    pair = pt.TwoBodies(ball, ball, G=1.0)
    start = pair.state((2, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1), (0, 0, 0.5)])
    motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, [1.0], dense=True)
    names = {name for name in dir(motion) if not name.startswith("_")}
    assert {"position", "primary", "elements", "energy", "dataset", "norm_error"} <= names
    assert not names & {"quaternion", "omega_body", "torques_body", "euler"}
    one = {name for name in dir(motion.primary) if not name.startswith("_")}
    assert {"quaternion", "torques_body", "forces_space"} <= one
    assert not one & {"position", "secondary"}
    for name in ("quaternion", "omega_space", "attitude", "torques_body", "forces_space"):
        with pytest.raises(AttributeError, match=r"^a motion of two bodies has no [a-z_]+\. Read primary\."):
            getattr(motion, name)
    for name in ("position", "acceleration", "distance", "elements", "orbit_frame", "primary"):
        with pytest.raises(AttributeError, match=r"^a motion of one body has no [a-z_]+: it belongs to"):
            getattr(motion.primary, name)
    with pytest.raises(AttributeError, match=r"^one of two bodies has no potential_energy of its own: take"):
        motion.primary.energy  # noqa: B018


BALL = pt.Body((0.4, 0.4, 0.4), mass=1.0)
PAIR = pt.TwoBodies(BALL, BALL, G=1.0)


def motion_of_one():
    return pt.free_motion(BALL, BALL.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0, 1.0])


def motion_of_two():
    start = PAIR.state((2, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1), (0, 0, 0.5)])
    return pt.propagate(pt.System(PAIR, pt.forces.MutualGravity()), start, [0.0, 1.0])


@checked
def distance(motion: OfTwoBodies) -> float:
    return float(motion.distance[0])


def test_functions_of_two_bodies_take_no_other_motion():
    assert is_of_two_bodies(motion_of_two())
    assert not is_of_two_bodies(motion_of_one())
    assert not is_of_two_bodies(motion_of_two().primary)
    assert distance(motion_of_two()) == 2.0
    for motion in (motion_of_one(), motion_of_two().primary):
        with pytest.raises(TypeError, match=r"^motion must be the motion of two bodies, got the motion of one body\.$"):
            distance(motion)
    with pytest.raises(TypeError, match=r"^motion must be a Trajectory, got int\.$"):
        distance(3)


def test_one_body_of_any_motion():
    alone, both = motion_of_one(), motion_of_two()
    assert of_one_body(alone, None) is alone
    assert np.array_equal(of_one_body(both, "secondary").omega_body, both.secondary.omega_body)
    with pytest.raises(ValueError, match=r"^body must be primary or secondary, got none\.$"):
        of_one_body(both, None)
    with pytest.raises(ValueError, match=r"^body must be primary or secondary, got moon\.$"):
        of_one_body(both, "moon")
    with pytest.raises(ValueError, match=r"^body must not be there for a motion of one body, got primary\.$"):
        of_one_body(alone, "primary")
