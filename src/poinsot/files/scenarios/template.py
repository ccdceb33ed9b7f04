"""A scenario to start from."""

__all__ = ["START"]

START = """\
# A scenario of poinsot: `poinsot run` computes the motion that it describes.
# Numbers are in units of your own, which must go together: here kg m2 of the body, km and s of the orbit.
# Angles, rates and times may say theirs.
title = "A satellite that points down, a little off"

[units]                        # names for results and pictures
time = "s"                     # s, min, h or d where rates or times have a unit
inertia = "kg m2"

[body]                         # principal moments of inertia
moments = [500, 600, 400]
# type = "Body.from_box"       # or Body.from_inertia, Body.from_ellipsoid, Body.from_cylinder, Body.from_ratios, ...
# mass = 100
# sides = [1.0, 1.5, 2.0]

[state]                        # exactly one attitude, and exactly one rate or angular momentum
roll_pitch_yaw = ["2 deg", "1 deg", "0 deg"]
omega_body = ["0 deg/s", "0 deg/s", "0.01 deg/s"]  # relative to the frame
frame = "earth"                # radial, transverse, normal; roll, pitch, yaw are from forward, sideways, down
# quaternion = [1, 0, 0, 0]    # scalar first, body to space, or to the frame
# time = "0 s"

[[forces]]                     # as many as there are; none is free motion
type = "GravityGradient"
orbit = "earth"

[orbits.earth]                 # where the body is: each orbit has a name
type = "KeplerOrbit"
mu = 398600.4418               # km3/s2
semimajor_axis = 7000
eccentricity = 0.01
inclination = "51.6 deg"
node = 0
argument_of_periapsis = 0

[times]                        # start, and stop or periods of an orbit, and count or step; or values = [...]
periods = 5
orbit = "earth"
count = 501

# [run]
# formulation = "canonical"    # default: lie_poisson, the fastest
# tolerance = 1e-12            # default: truncation below rounding

# [outputs]                    # names without folders; default: a result of the name of this file
# result = "satellite.nc"      # .nc or .zarr
# plot = "satellite.png"
# view = "satellite.html"

# [ensemble]                   # many members, spread around this one
# members = 100
# seed = 1
# [[ensemble.spread]]
# of = "state.omega_body"      # a number above by its place; state.turn turns the attitude about the body axes
# distribution = "normal"      # or uniform
# size = "0.01 deg/s"          # standard deviation, or half the width
"""
