"""Basilisk: a spacecraft of facets in sunlight or in air, its own effectors, and two of its integrators.

Its steps do not stop where a facet turns into the light or out of it, so that the error falls with the step.
"""

import numpy as np
from Basilisk.architecture import messaging
from Basilisk.simulation import facetDragDynamicEffector, facetSRPDynamicEffector, spacecraft, svIntegrators
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, orbitalMotion, simIncludeGravBody

AU = 149597870700.0
TOLERANCE = 1e-13
INTEGRATORS = "RKF78", "RK4"
"""The first chooses steps within those of the task, the second, which is the default, takes those of the task."""


def prepare(case, name, step):
    """Return one simulation, set up, that gives the quaternion at the end; its task runs in whole nanoseconds."""
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("process").addTask(simulation.CreateNewTask("task", round(1e9 * step)))
    craft = spacecraft.Spacecraft()
    craft.ModelTag = "craft"
    craft.hub.mHub = 1e9  # so that the forces, of which the reference has the torques alone, do not change the orbit
    craft.hub.r_BcB_B = np.zeros((3, 1)).tolist()
    craft.hub.IHubPntBc_B = case["inertia"]
    craft.hub.sigma_BNInit = RigidBodyKinematics.EP2MRP(case["quaternion0"])
    craft.hub.omega_BN_BInit = case["omega_body0"]
    simulation.AddModelToTask("task", craft)
    effector, *others = _in_sunlight(case, craft) if "pressure" in case else _in_air(case, craft)
    effector.ModelTag = "facets"
    craft.addDynamicEffector(effector)
    simulation.AddModelToTask("task", effector)
    integrator = getattr(svIntegrators, f"svIntegrator{name}")(craft)
    if name == "RKF78":
        integrator.setRelativeTolerance(TOLERANCE)
        integrator.setAbsoluteTolerance(TOLERANCE * float(np.linalg.norm(case["omega_body0"])))
    craft.setIntegrator(integrator)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(round(1e9 * case["times"][-1]))
    alive = (effector, integrator, *others)  # the simulation holds pointers only

    def run(_alive=alive):
        simulation.ExecuteSimulation()
        return RigidBodyKinematics.MRP2EP(np.array(craft.scStateOutMsg.read().sigma_BN))

    return run


def _in_sunlight(case, craft):
    """Return the effector of radiation pressure and its message; the craft stays where it is."""
    craft.hub.r_CN_NInit = craft.hub.v_CN_NInit = np.zeros((3, 1)).tolist()
    effector = facetSRPDynamicEffector.FacetSRPDynamicEffector()
    effector.setNumFacets(len(case["facets"]))
    effector.setNumArticulatedFacets(0)
    for facet in case["facets"]:
        optics = facet["diffuse"], facet["specular"]
        effector.addFacet(
            facet["area"], np.eye(3).tolist(), facet["normal"], [0.0, 0.0, 0.0], facet["position"], *optics
        )
    sun = messaging.SpicePlanetStateMsgPayload()
    sun.PositionVector = (AU * np.array(case["sun_direction_space"])).tolist()
    message = messaging.SpicePlanetStateMsg().write(sun)
    effector.sunInMsg.subscribeTo(message)
    return effector, message


def _in_air(case, craft):
    """Return the effector of drag, its message and the Earth; the density of a circular orbit is one number."""
    bodies = simIncludeGravBody.gravBodyFactory()
    earth = bodies.createEarth()
    earth.mu, earth.isCentralBody = case["mu"], True
    elements = orbitalMotion.ClassicElements()
    elements.a, elements.e, elements.omega = case["semimajor_axis"], 0.0, 0.0
    elements.i, elements.Omega, elements.f = case["inclination"], case["node"], case["argument_of_latitude0"]
    craft.hub.r_CN_NInit, craft.hub.v_CN_NInit = orbitalMotion.elem2rv(earth.mu, elements)
    bodies.addBodiesTo(craft)
    effector = facetDragDynamicEffector.FacetDragDynamicEffector()
    for facet in case["facets"]:
        effector.addFacet(facet["area"], facet["drag"], facet["normal"], facet["position"])
    height = case["semimajor_axis"] - case["planet_radius"]
    air = messaging.AtmoPropsMsgPayload()
    air.neutralDensity = case["rho0"] * np.exp(-height / case["scale_height"])
    message = messaging.AtmoPropsMsg().write(air)
    effector.atmoDensInMsg.subscribeTo(message)
    return effector, message, bodies, earth
