"""Three problems of Sec. 6 of Arribas, Elipe and Palacios (2006), in every reading of their text.

The printed pair (q, Q) and the printed Euler set, called equivalent there, are two different states
(erratum E9); the potential of the heavy top has the wrong sign as printed (E8); docs/paper.md lists all errata.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from poinsot.atomic_write import new_file
from poinsot.errors import PropagationError
from poinsot.files.netcdf import save
from poinsot.forces.gravity import GravityGradient, UniformGravity
from poinsot.integration.formulations import DEFAULT_FORMULATION, GENERAL
from poinsot.kinematics.attitude import rotation_angle
from poinsot.kinematics.state import State
from poinsot.mechanics.body import Body
from poinsot.orbits.kepler import KeplerOrbit
from poinsot.plot.time_series import quaternions
from poinsot.propagation.propagate import propagate
from poinsot.propagation.trajectory import Trajectory
from poinsot.systems.system import System

__all__ = ["HEADINGS", "PERIGEE", "PROBLEMS", "ErrorRow", "PaperProblem", "markdown_table", "solve", "write"]

TOP = Body((1.25, 1.0, 0.75))
SATELLITE = Body((400.0, 500.0, 600.0))
EARTH_MU, EARTH_RADIUS = 398600.4418, 6378.137  # km^3/s^2 and km; the paper gives none
ORBIT = KeplerOrbit(
    mu=EARTH_MU,
    semimajor_axis=7000.0,
    eccentricity=0.2,
    inclination=np.pi / 6,
    node=np.pi / 4,
    argument_of_periapsis=np.pi / 12,
)
PERIGEE = (
    f"The perigee of the satellite, {ORBIT.periapsis_distance:g} km from the centre, is "
    f"{EARTH_RADIUS - ORBIT.periapsis_distance:.3f} km below the surface (erratum E11): "
    "the Earth is computed as a point."
)
PRINTED_PAIR = State(
    quaternion=(0.5, -1 / np.sqrt(2), 0, 0.5), conjugate_momenta=(0.3, -0.6 * np.sqrt(2), 0.1 * np.sqrt(2), -1.5)
)
EULER_SET = State.from_euler(angles=(np.pi / 4, 3 * np.pi / 2, np.pi / 4), momenta=(0.5, 0.6, 0.4))

FREE = System(TOP)
HEAVY_TOP = System(TOP, UniformGravity(weight=0.5, center_of_mass=(1, 0, 0)))
HEAVY_TOP_AS_PRINTED = System(TOP, UniformGravity(weight=0.5, center_of_mass=(-1, 0, 0)))
KEPLER = System(SATELLITE, GravityGradient(ORBIT), units={"time": "s", "inertia": "kg m2"})


@dataclass(frozen=True)
class PaperProblem:
    """System with initial values from one reading of the paper, over the time of its figure."""

    name: str
    title: str
    system: System
    state: State
    times: NDArray[np.float64]


def _problems() -> Iterator[PaperProblem]:
    dimensionless, orbital = np.linspace(0, 100, 2001), np.linspace(0, 10 * ORBIT.period, 2001)
    for reading, words, state in (
        ("", "printed pair (q, Q)", PRINTED_PAIR),
        ("-euler-set", "printed Euler set", EULER_SET),
    ):
        yield PaperProblem(f"fig1-torque-free{reading}", f"Torque-free, {words}", FREE, state, dimensionless)
        yield PaperProblem(f"fig2-heavy-top{reading}", f"Heavy top, {words}", HEAVY_TOP, state, dimensionless)
        yield PaperProblem(
            f"fig2-heavy-top{reading}-printed-sign",
            f"Heavy top with the printed sign of (18), {words}",
            HEAVY_TOP_AS_PRINTED,
            state,
            dimensionless,
        )
        yield PaperProblem(f"fig3-kepler{reading}", f"Satellite on a Kepler orbit, {words}", KEPLER, state, orbital)


PROBLEMS = tuple(sorted(_problems(), key=lambda problem: problem.name))


@dataclass(frozen=True)
class ErrorRow:
    """Line of the table: errors of a problem in one formulation, or the time at which it stopped."""

    problem: str
    formulation: str
    steps: str = "-"
    order: str = "-"
    milliseconds: str = "-"
    norm_error: str = "-"
    tangency_error: str = "-"
    drift: str = "-"
    attitude_error: str = "-"


HEADINGS = ("case", "formulation", "steps", "order", "ms", "|q|-1", "q.Q/|Q|", "drift", "error (rad)")
"""Headings of the fields of a row. Errors and drifts are the largest of the run."""


def solve(problem: PaperProblem) -> tuple[Trajectory, list[ErrorRow]]:
    """Integrate a problem in every formulation; return the default motion and the table's rows.

    The attitude error is the largest angle to a run of another formulation in quadruple precision.
    """
    references = {
        name: propagate(problem.system, problem.state, problem.times, formulation=name, precision="quadruple")
        for name in ("canonical", "lie_poisson")
    }
    motions, rows = {}, []
    for name in GENERAL:
        reference = references["lie_poisson" if name == "canonical" else "canonical"]
        try:
            propagate(problem.system, problem.state, problem.times[:2], formulation=name)  # compiles
            motions[name] = propagate(problem.system, problem.state, problem.times, formulation=name)
        except PropagationError as error:
            rows.append(ErrorRow(problem.name, name, attitude_error=f"stopped at t = {error.time:.6g}"))
        else:
            rows.append(_row(problem.name, motions[name], reference))
    return motions[DEFAULT_FORMULATION], rows


def write(motion: Trajectory, problem: PaperProblem, folder: Path) -> None:
    """Write the figure of a problem as PNG and PDF, and its motion as NetCDF."""
    import matplotlib.pyplot as plt

    figure = quaternions(motion, title=problem.title)[0].figure
    for suffix in (".png", ".pdf"):
        with new_file(folder / f"{problem.name}{suffix}", overwrite=True) as part:
            figure.savefig(part, dpi=150)
    plt.close(figure)
    save(motion, folder / f"{problem.name}.nc", overwrite=True)


def markdown_table(rows: list[ErrorRow]) -> str:
    """Return the rows as a Markdown table."""
    lines = [HEADINGS, ["---"] * len(HEADINGS), *(vars(row).values() for row in rows)]
    return (
        "\n".join(f"| {' | '.join(str(cell).replace('|', chr(92) + '|') for cell in line)} |" for line in lines) + "\n"
    )


def _row(name: str, run: Trajectory, reference: Trajectory) -> ErrorRow:
    drift = run.drift
    largest = {integral.symbol: np.max(np.abs(drift[integral.name])) for integral in run.system.integrals}
    return ErrorRow(
        name,
        run.run.formulation,
        str(run.run.steps),
        str(run.run.order),
        f"{1e3 * run.run.wall_time:.2f}",
        f"{np.max(np.abs(run.norm_error)):.1e}",
        f"{np.max(np.abs(run.tangency_error)):.1e}",
        ", ".join(f"{symbol} {value:.1e}" for symbol, value in largest.items()) or "none",
        f"{np.max(rotation_angle(reference.quaternion, run.quaternion)):.1e}",
    )
