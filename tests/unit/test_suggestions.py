"""First guesses of users of other tools, each with the answer of the error message."""

import inspect
import pickle
import re
from typing import Any

import pytest

import poinsot as pt
from poinsot.habits import HABITS
from poinsot.suggestions import nearest

BODY = pt.Body((1.0, 2.0, 3.0))
ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1)
SYSTEM = pt.System(BODY)
STATE = BODY.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.1))
MOTION = pt.propagate(SYSTEM, STATE, [0.0, 1.0])
HEAVY = pt.Body((1.0, 2.0, 3.0), mass=1.0)
PAIR_STATE = pt.TwoBodies(HEAVY, HEAVY).state((9.0, 0, 0), (0, 0.1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 1)] * 2)
NAMES: dict[str, Any] = {
    "pair_state": PAIR_STATE,
    "pt": pt,
    "body": BODY,
    "orbit": ORBIT,
    "system": SYSTEM,
    "state": STATE,
    "motion": MOTION,
}

PROPAGATE = "Write poinsot.propagate(system, state, times)."
SYSTEMS = "Write poinsot.System(body, *forces)."
MOMENTUM = "Write motion.angular_momentum_body or motion.angular_momentum_space."
OMEGA = "Write motion.omega_body or motion.omega_space."

GUESSES = {
    # names of the package
    "pt.ReactionWheels": "Write poinsot.parts.ReactionWheels.",
    "pt.igrf": "Write poinsot.forces.IGRF.",
    "pt.body": "Write poinsot.Body.",
    "pt.lyapunov_spectrum": "Write poinsot.analysis.lyapunov_spectrum.",
    "pt.read_oem": "Write poinsot.files.read_oem.",
    "pt.Spacecraft": SYSTEMS,
    "pt.Satellite": SYSTEMS,
    "pt.RigidBody": "Write poinsot.Body(moments).",
    "pt.simulate": PROPAGATE,
    "pt.integrate": PROPAGATE,
    "pt.solve_ivp": PROPAGATE,
    "pt.Simulation": PROPAGATE,
    "pt.propogate": "Did you mean 'propagate'?",
    "pt.Quaternion": "Write scipy.spatial.transform.Rotation, or four numbers with the scalar first, as an attitude.",
    "pt.Kepler": "Write poinsot.KeplerOrbit.",
    "pt.load_scenario": "Write poinsot.files.read_scenario(path).",
    "pt.Wheel": "Write poinsot.parts.ReactionWheels or poinsot.parts.MomentumWheel.",
    "pt.forces.Drag": "Write poinsot.forces.AtmosphericDrag(orbit, atmosphere, facets).",
    "pt.forces.J2": "Write poinsot.forces.Oblateness.",
    "pt.forces.SolarRadiationPressure": "Write poinsot.forces.RadiationPressure(sun, facets).",
    "pt.forces.ReactionWheels": "Write poinsot.parts.ReactionWheels.",
    "pt.observables.IMU": "Write poinsot.observables.Gyro(bias=...).",
    "pt.observables.StarCamera": "Write poinsot.observables.StarTracker(mounting=...).",
    "pt.observables.SunSensor": "Write poinsot.observables.VectorSensor(sun, occulters=...), with an orbit.",
    "pt.observables.CSS": "Write poinsot.observables.CoarseSunSensors(sun, normals).",
    "pt.observables.HorizonSensor": "Write poinsot.observables.VectorSensor(orbit, field_of_view=...).",
    "pt.Magnetometer": "Write poinsot.observables.Magnetometer.",
    "pt.observables.GroundStation": "Write poinsot.orbits.GroundStation(orbit, rotation, latitude=..., longitude=...).",
    "pt.orbits.EarthLocation": "Write poinsot.orbits.GroundStation(orbit, rotation, latitude=..., longitude=...).",
    "pt.observables.Gyro(drift=(1, 0, 0))": "Write bias.",
    "pt.observables.VectorSensor((1, 0, 0), fov=1.0)": "Write field_of_view, the largest angle from the boresight.",
    "pt.orbits.GroundStation(orbit, None, lat=0.1)": "Write latitude.",
    "pt.parts.Rotor": "Write poinsot.parts.Gyrostat or poinsot.parts.MomentumWheel.",
    "pt.control.PID": "Write poinsot.control.QuaternionFeedback, or a Torque of your own.",
    "pt.analysis.lyapunov": "Write poinsot.analysis.lyapunov_spectrum(system, state, times).",
    "pt.analysis.poincare": "Write poinsot.analysis.section(motion, coordinates).",
    "pt.analysis.fft": "Write poinsot.analysis.frequencies(signal, times).",
    "pt.plot.attitude": "Write poinsot.plot.quaternions(motion) or poinsot.plot.euler_angles(motion).",
    "pt.plot.omega": "Write poinsot.plot.angular_velocity(motion).",
    "pt.files.read_tle": "Write poinsot.files.tle_orbit(lines, start, stop).",
    "pt.functions.arctan2": "Write poinsot.functions.atan2.",
    # attributes
    "motion.omega": OMEGA,
    "motion.w": OMEGA,
    "motion.angular_momentum": MOMENTUM,
    "motion.H": MOMENTUM,
    "motion.t": "Write motion.times.",
    "motion.time": "Write motion.times.",
    "motion.q": "Write motion.quaternion.",
    "motion.y": "Write motion.variables.",
    "motion.quaternions": "Write motion.quaternion.",
    "motion.save('x.nc')": "Write poinsot.save(motion, path).",
    "motion.to_dataframe()": "Write motion.dataset.to_dataframe().",
    "motion.to_netcdf('x.nc')": "Write poinsot.save(motion, path).",
    "motion.sol": "Write motion(time), after propagate(..., dense=True).",
    "motion.t_events": "Write motion.events[i].times.",
    "motion.success": "Write motion.reached.",
    "motion.kinetic_enrgy": "Did you mean 'kinetic_energy'?",
    "state.omega_body": "Write system.omega_body(state): the angular velocity depends on the inertia tensor.",
    "state.q": "Write quaternion.",
    "body.I": "Write body.inertia, the tensor; body.moments, the principal moments.",
    "body.inertia_tensor": "Write body.inertia.",
    "orbit.raan": "Write node.",
    "orbit.a": "Write semimajor_axis.",
    "orbit.position": "Write position_at(time).",
    "system.add_force": "Write System(body, *forces) with all forces: a system stays as it was made.",
    "system.propagate": PROPAGATE,
    # calls
    "pt.propagate(system, state, 10)": "Write [10.0].",
    "pt.propagate(system, state, t=[1.0])": "Write times.",
    "pt.propagate(system, state, [1.0], t_eval=[1.0])": "Write times.",
    "pt.propagate(system, state, [1.0], rtol=1e-9)": "Write tolerance=..., the relative truncation error of a step.",
    "pt.propagate(system, state, [1.0], dense_output=True)": "Write dense=True.",
    "pt.propagate(system, state, [1.0], n_jobs=2)": "Write threads.",
    "pt.propagate(system, state, [1.0], formulaton='canonical')": "Did you mean 'formulation'?",
    "pt.propagate(state, system, [1.0])": "The order is propagate(system, state, times).",
    "pt.State(omega_body=(0, 0, 1))": "Write body.state(attitude, omega_body=...).",
    "body.state((1, 0, 0, 0), w=(0, 0, 1))": "Write omega_body=... for components along the body axes or "
    "omega_space=... for components in space.",
    "body.state(q=(1, 0, 0, 0), omega_body=(0, 0, 1))": "Write body.state((1, 0, 0, 0), omega_body=...): the "
    "attitude is the first argument, a quaternion or a Rotation.",
    "pt.Body(inertia=((1, 0, 0), (0, 2, 0), (0, 0, 3)))": "Write poinsot.Body.from_inertia(tensor), or Body((A, B, C)) "
    "with the principal moments.",
    "pt.Body(((1, 0, 0), (0, 2, 0), (0, 0, 3)))": "Write Body.from_inertia(tensor).",
    "pt.Body(1, 2, 3)": "Write Body((A, B, C)), or Body.from_inertia(tensor).",
    "pt.propagate(system, state, 0, 10)": "Write the times as one array, numpy.linspace(start, stop, count).",
    "body.state((1, 0, 0, 0), (0, 0, 1))": "Write body.state(attitude, omega_body=...): vectors need their names.",
    "system.state((1, 0, 0, 0), rates=(0, 0, 1))": "Write omega_body=... for components along the body axes or "
    "omega_space=... for components in space.",
    "pt.System(body, forces=[])": "Write the forces one by one: System(body, force, another_force).",
    "pt.forces.LinearDamping(gain=1.0)": "The arguments are coefficient.",
    "pt.control.QuaternionFeedback(Kp=1.0, Kd=2.0)": "Did you mean 'kp'?",
    "pt.KeplerOrbit.from_vectors(1.0, r=(1, 0, 0), v=(0, 1, 0))": "Write position.",
    "motion.euler('321', degrees=True)": "Write numpy.degrees(angles): angles are in radians.",
    "pt.free_motion(body, state, t=[1.0])": "Write times.",
    # attributes of classes
    "pt.Body.from_tensor": "Write Body.from_inertia(tensor).",
    "pt.KeplerOrbit.from_state_vectors": "Write KeplerOrbit.from_vectors(mu, position=..., velocity=...).",
    "pt.KeplerOrbit.from_element": "Did you mean 'from_elements'?",
    "pt.State.from_quaternion": "Write body.state(quaternion, omega_body=...).",
    "motion.final": "Write motion[-1].",
    "motion.state": "Write motion[i], or motion(time) after propagate(..., dense=True).",
    "motion.yaw": "Write motion.relative_to(orbit.frame).roll_pitch_yaw.",
    "motion.distances": "Trajectory has no attribute 'distances'.",
    "orbit.state(1.0)": "Write position_at(time) and velocity_at(time).",
    "orbit.frame.dcm": "Write attitude(time).",
    "pair_state.velocity": "Write state.momentum, the relative momentum, divided by the reduced mass.",
    "pair_state.q": "Write state.primary.quaternion or state.secondary.quaternion.",
    "system.at(state).w": "Write omega_body, the components along body axes.",
    "motion.body_omega": "Did you mean 'omega_body'?",
    "pt.shapes.Box": "Write poinsot.Body.from_box(mass, sides).",
    "getattr(pt, 'a.b')": "poinsot has no attribute 'a.b'.",
    "pt.System(body, [pt.GravityGradient(orbit)])": "Give them one by one: System(body, *forces).",
    "pt.KeplerOrbit(mu=1, mean_anomaly=0)": "Write KeplerOrbit.from_elements(mu, ..., mean_anomaly=...).",
    "pt.KeplerOrbit(1.0, 7000.0)": "KeplerOrbit() must be called as KeplerOrbit(mu, semimajor_axis=..., "
    "eccentricity=...), got too many positional arguments.",
    "pt.KeplerOrbit(1.0, semimajor_axis=7000.0)": "KeplerOrbit() must be called as KeplerOrbit(mu, semimajor_axis=..., "
    "eccentricity=...), got no eccentricity.",
    "pt.KeplerOrbit.from_elements(1.0, semimajor_axis=1.0, eccentricity=0, raan=0)": "Write node.",
    "pt.GravityGradient(mu=1.0)": "Write GravityGradient(orbit), with the orbit KeplerOrbit(mu, ...) or another.",
    "pt.save(motion, filename='x.nc')": "Write path.",
}


@pytest.mark.parametrize("guess", GUESSES)
def test_answer_to_a_guess(guess):
    with pytest.raises((AttributeError, TypeError, ValueError)) as caught:
        eval(guess, NAMES)
    message = str(caught.value)
    assert message.endswith(GUESSES[guess])
    assert "\n" not in message


def test_answers_name_what_exists():
    for habits in HABITS.values():
        for answer in habits.values():
            for path in re.findall(r"poinsot\.([\w.]+)", answer):
                found = pt
                for name in path.strip(".").split("."):
                    found = getattr(found, name)
    for key, name in (("Trajectory", "motion"), ("State", "state"), ("Body", "body"), ("System", "system")):
        for guess, answer in HABITS[key].items():
            assert not hasattr(NAMES[name], guess), (key, guess)
            for attribute in re.findall(rf"\b{name}\.(\w+)", answer):
                assert hasattr(NAMES[name], attribute), (key, attribute)


def test_keywords_of_habits_do_not_exist():
    for call in ("propagate", "save", "view"):
        assert HABITS[f"{call}()"].keys().isdisjoint(inspect.signature(getattr(pt, call)).parameters)
    for call, function in (("state", BODY.state), ("from_elements", ORBIT.from_elements), ("Body", pt.Body)):
        wrong = HABITS[f"{call}()"].keys() & inspect.signature(function).parameters.keys()
        assert all(HABITS[f"{call}()"][name] == name for name in wrong)


@pytest.mark.parametrize("name", ["ReactionWheels", "Satellite", "propogate"])
def test_import_of_a_guess(name):
    with pytest.raises(ImportError) as caught:
        exec(f"from poinsot import {name}")
    assert str(caught.value).endswith(GUESSES[f"pt.{name}"])


def test_errors_travel_as_texts():
    with pytest.raises(AttributeError) as caught:
        _ = NAMES["motion"].omega
    (message,) = pickle.loads(pickle.dumps(caught.value)).args
    assert message == str(caught.value)


def test_python_adds_no_suggestion_of_its_own():
    for guess in ("pt.propogate", "motion.kinetic_enrgy", "pt.Body.from_inertias"):
        with pytest.raises(AttributeError) as caught:
            eval(guess, NAMES)
        assert caught.value.name == guess.rpartition(".")[2]
        assert caught.value.obj is None


def test_errors_of_properties_are_not_hidden():
    class Own(pt.Body):
        @property
        def broken(self):
            return self.moments.no_such_attribute

    with pytest.raises(AttributeError, match=r"'numpy\.ndarray' object has no attribute 'no_such_attribute'"):
        _ = Own((1.0, 1.0, 1.0)).broken


def test_type_errors_of_constructors_are_not_hidden():
    class Own(pt.Body):
        def __init__(self, gain):
            self.gain = len(gain)

    with pytest.raises(TypeError, match="has no len"):
        Own(1.0)


def test_nearest_name():
    assert nearest("Frame_", ["frames", "other"]) == " Did you mean 'frames'?"
    assert nearest("entirely", ["frames", "other"]) == ""
