"""Basilisk: a spacecraft with a gravity-gradient effector, RKF78, the orbit integrated along."""

import numpy as np
from Basilisk.simulation import GravityGradientEffector, spacecraft, svIntegrators
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, orbitalMotion, simIncludeGravBody

from benchmarks.problems import ellipse
from poinsot.validation import paper

SOLVES = ("satellite",)
LEVELS = ((1e-8, 400), (1e-10, 400), (1e-12, 1000), (1e-13, 3000), (1e-14, 3000), (1e-14, 6000))  # tolerance, tasks
SHORT_LEVELS = ((1e-12, 1000), (1e-14, 3000))
KM = 1000.0


def _spacecraft(problem, earth_mu):
    craft = spacecraft.Spacecraft()
    craft.ModelTag = "craft"
    craft.hub.mHub = 1.0
    craft.hub.r_BcB_B = [[0.0], [0.0], [0.0]]
    craft.hub.IHubPntBc_B = np.diag(problem.moments).tolist()
    elements = orbitalMotion.ClassicElements()
    elements.a, elements.e, elements.f = ellipse().a * KM, ellipse().e, 0.0
    elements.i, elements.Omega = float(paper.ORBIT.inclination), float(paper.ORBIT.node)
    elements.omega = float(paper.ORBIT.argument_of_periapsis)
    craft.hub.r_CN_NInit, craft.hub.v_CN_NInit = orbitalMotion.elem2rv(earth_mu, elements)
    craft.hub.sigma_BNInit = RigidBodyKinematics.EP2MRP(problem.initial[:4])
    craft.hub.omega_BN_BInit = problem.initial[4:]
    return craft


def prepare(problem, level):
    """Return one simulation, set up; its task runs in whole nanoseconds, so that it names its own end."""
    tolerance, tasks = level
    step = round(problem.end / tasks * 1e9)
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("process").addTask(simulation.CreateNewTask("task", step))
    bodies = simIncludeGravBody.gravBodyFactory()
    earth = bodies.createEarth()
    earth.mu, earth.isCentralBody = ellipse().mu * KM**3, True
    craft = _spacecraft(problem, earth.mu)
    simulation.AddModelToTask("task", craft)
    bodies.addBodiesTo(craft)
    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.ModelTag = "gradient"
    gradient.addPlanetName(earth.planetName)
    craft.addDynamicEffector(gradient)
    simulation.AddModelToTask("task", gradient)
    integrator = svIntegrators.svIntegratorRKF78(craft)
    integrator.setRelativeTolerance(tolerance)
    integrator.setAbsoluteTolerance(tolerance * problem.smallest)
    craft.setIntegrator(integrator)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(step * tasks)
    alive = (bodies, earth, gradient, integrator)  # the simulation holds pointers only

    def run(_alive=alive):
        simulation.ExecuteSimulation()
        return RigidBodyKinematics.MRP2EP(np.array(craft.scStateOutMsg.read().sigma_BN)), step * tasks * 1e-9

    return run
