"""Instances of every class of records, and systems of several kinds of records."""

import poinsot as pt
from kinds import control_laws, events, forces, mutual_gravity, orbits, pair_events, pairs, parts
from poinsot.forces import IGRF

FAR = pt.orbits.FixedPosition(398600.4, position=(6871.2, 0, 0))
EARTH = pt.orbits.RotationModel.iau("earth", calendar=pt.Calendar("2026-11-21T00:00:00", "TT"))
PAIR_FORCES = [force for name in pairs.NAMES for force in pairs.forces_of(name)]
RECORDS = {
    "force": forces.FORCES,
    "mutual gravity": mutual_gravity.FORCES,
    "force on two bodies": PAIR_FORCES,
    "orbit": orbits.ORBITS.values(),
    "part": parts.PARTS,
    "control law": (*control_laws.LAWS, *control_laws.SAMPLED),
    "magnetic field": (*forces.MAGNETIC_FIELDS, IGRF(FAR, EARTH, 2)),
    "event": [event for event, _ in events.EVENTS.values()],
    "event of two bodies": [event for event, _ in pair_events.EVENTS.values()],
}
SYSTEMS = {
    "ellipsoid": (pt.Body((1.3, 1.0, 0.7)), pt.GravityGradient(forces.ELLIPSE)),
    "table": (pt.Body((1.3, 1.0, 0.7)), pt.GravityGradient(orbits.ORBITS["table"])),
    "part": (parts.BODY, parts.PARTS[1], forces.FORCES[0]),
    "own part": (parts.BODY, parts.Gimbal(0.7, 1.5)),
    "sampled law": (control_laws.BODY, control_laws.SAMPLED[-1]),
}
