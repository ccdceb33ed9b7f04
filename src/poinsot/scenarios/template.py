"""Example scenario that `poinsot new` writes."""

__all__ = ["START"]

START = """\
# Scenario for poinsot: `poinsot run` propagates the rotation that this file describes.
# Numbers are in any consistent set of units: here kg m2 for the body, km and s for the orbit.
# An angle, rate or time can also be a string with its unit, such as "2 deg".
title = "Libration of a satellite that points to the Earth"

[units]                        # units of the numbers below, for the labels of results and plots
time = "s"                     # s, min, h or d if rates or times are strings with a unit
inertia = "kg m2"

[body]                         # principal moments of inertia
moments = [500, 600, 400]
# type = "Body.from_box"       # or Body.from_inertia, Body.from_ellipsoid, Body.from_cylinder, Body.from_ratios, ...
# mass = 100
# sides = [1.0, 1.5, 2.0]

[state]                        # one attitude, and one angular velocity or angular momentum
roll_pitch_yaw = ["2 deg", "1 deg", "0 deg"]
omega_body = ["0 deg/s", "0 deg/s", "0.01 deg/s"]  # relative to the frame
frame = "earth"                # orbital frame of [orbits.earth]; roll and yaw axes forward and down at zero angles
# quaternion = [1, 0, 0, 0]    # scalar first, from body axes to space, or to the frame if there is one
# time = "0 s"

[[forces]]                     # one such table for each force or torque; without any the rotation is free
type = "GravityGradient"
orbit = "earth"

[orbits.earth]                 # Kepler orbit of the body about the Earth, named "earth"
type = "KeplerOrbit"
mu = 398600.4418               # km3/s2
semimajor_axis = 7000
eccentricity = 0.01
inclination = "51.6 deg"
node = 0
argument_of_periapsis = 0

[times]                        # stop = ... or periods of an orbit, with count or step; or values = [...]
periods = 5
orbit = "earth"
count = 501

# [run]
# formulation = "canonical"    # variables of the integration; default: lie_poisson, the fastest
# tolerance = 1e-12            # relative truncation error of a step; default: 2.2e-16, below rounding errors

# [outputs]                    # file names without folders; default: the result, with the name of this file
# result = "satellite.nc"      # .nc or .zarr
# plot = "satellite.png"
# view = "satellite.html"

# [ensemble]                   # Monte Carlo ensemble around the scenario above
# members = 100
# seed = 1
# [[ensemble.spread]]
# of = "state.omega_body"      # key of the varied numbers; state.turn rotates the attitude about the body axes
# distribution = "normal"      # or uniform
# size = "0.01 deg/s"          # standard deviation; half the width of a uniform distribution
"""
