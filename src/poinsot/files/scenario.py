"""Scenario files: a propagation described in TOML."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import Unpack, override

from poinsot.checked import checked
from poinsot.display.html_text import Summarized, formatted, formatted_times, rounded
from poinsot.errors import PropagationError, PropagationInterrupted
from poinsot.files.untrusted import read_text
from poinsot.kinematics.state import AnyState
from poinsot.mechanics.observable import Observable
from poinsot.observables.readings import Readings
from poinsot.printable import quoted, shortened
from poinsot.propagation.free_motion.motion import free_motion
from poinsot.propagation.observe import observe
from poinsot.propagation.propagate import propagate
from poinsot.propagation.scenario_of_motion import WHOLE, WITH_FILES, scenario_of
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array
from poinsot.scenarios.toml_text import MAX_CHARACTERS
from poinsot.storage.chunk_plan import Chunking
from poinsot.systems.system import System
from poinsot.systems.times_and_states import common_members

__all__ = ["Scenario", "parsed_scenario", "read_scenario", "repetition"]


@dataclass(frozen=True, repr=False, eq=False)
class Scenario(Summarized):
    """Scenario: a propagation described by a file, with its system, initial state, times and options.

    Attributes
    ----------
    name : str
        Name of the file.
    system : System
        Body with forces and parts.
    state : State or PairState
        Initial state.
    times : array (n,)
        Times of the results.
    run : mapping
        Options of the run: `method`, `formulation`, `tolerance`, `precision`, `dense`.
    outputs : mapping
        File names of the requested outputs `result`, `plot` and `view`.
    plans : tuple of Readings
        Readings without values of the tables `[[observe]]`, which `observe` reads along a motion.
    provenance : mapping
        Entries stored in a result: `title`, `seed`, and the text `scenario`.

    Examples
    --------
    >>> pt.files.read_scenario("top.toml").system
    System(Body(moments=[1.25, 1.0, 0.75]))
    """

    name: str
    system: System
    state: AnyState
    times: Array
    run: Mapping[str, Any] = field(default_factory=dict)
    outputs: Mapping[str, str] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)
    plans: tuple[Readings, ...] = ()

    @override
    def _summary(self) -> tuple[str, dict[str, str]]:
        return f"Scenario {self.name}: {rounded(repr(self.system))}", {
            "title": self.provenance.get("title") or "",
            "members": "".join(map(str, self.state.shape)),
            "start": formatted(self.state.time, self.system.units["time"]),
            "times": formatted_times(self.times, self.system.units["time"]),
            "run": rounded(", ".join(f"{name} {value}" for name, value in self.run.items())),
            "observes": ", ".join(plan.name for plan in self.plans),
            "writes": ", ".join(self.outputs.values()),
        }

    @property
    def instruments(self) -> tuple[Observable, ...]:
        """Observables at the output times, whose readings are variables of a propagated motion."""
        members = common_members(self.system, self.state)
        return tuple(
            plan.observable
            for plan in self.plans
            if np.array_equal(plan.times, self.times) and plan.observable.member_axis in ((), members)
        )

    @checked
    def propagate(
        self,
        *,
        threads: int | None = None,
        progress: bool | None = None,
        readings: bool = True,
        **chunking: Unpack[Chunking],
    ) -> Trajectory:
        """Propagate the scenario, with the arguments of `pt.propagate`, and return the motion.

        Parameters
        ----------
        readings : bool
            True to make the readings of `instruments` variables of the motion.

        Raises
        ------
        PropagationError, PropagationInterrupted
            If `pt.propagate` raises them. The partial trajectory contains the text of the scenario, too.
        """
        options = {name: value for name, value in self.run.items() if name != "method"}
        if chunking:
            chunking = {**chunking, "provenance": self.provenance}
        try:
            if self.run.get("method") == "closed form":
                motion = free_motion(
                    self.system.of_bodies[""], self.state.of_bodies[""], self.times, units=self.system.units, **chunking
                )
            else:
                options |= {"threads": threads, "progress": progress}
                options["observables"] = self.instruments if readings else ()
                motion = propagate(self.system, self.state, self.times, **options, **chunking)
        except (PropagationError, PropagationInterrupted) as stopped:
            if isinstance(stopped.trajectory, Trajectory):
                stopped.trajectory._complete(provenance=self.provenance)
            raise
        if isinstance(motion, Trajectory):  # a store of chosen variables or of reductions is a dataset
            motion._complete(provenance=self.provenance)
        return motion

    @checked
    def observe(self, motion: Trajectory | None = None, *, noise: int | None = None) -> tuple[Readings, ...]:
        """Return the readings of the tables `[[observe]]` along a motion, with the arguments of `pt.observe`.

        Parameters
        ----------
        motion : Trajectory, optional
            Motion of the scenario. Default: the scenario is propagated.
        noise : int, optional
            Seed of normally distributed errors with the standard deviations of the readings. The second observable has
            the next seed, and so on. Default: no errors.

        Raises
        ------
        ValueError
            If the scenario has no observables, or `pt.observe` raises an error.
        PropagationError, PropagationInterrupted
            If the propagation raises them.
        """
        if not self.plans:
            raise ValueError(f"{self.name} must have a table [[observe]] to be observed, got none.")
        motion = self.propagate(readings=False) if motion is None else motion
        found = [observe(motion, plan) for plan in self.plans]
        seen = [each for each in found if isinstance(each, Readings)]
        return tuple(seen if noise is None else [each.simulated(noise + i) for i, each in enumerate(seen)])


@checked
def read_scenario(path: str | Path) -> Scenario:
    """Return the propagation that a scenario file (TOML) describes.

    docs/scenarios.md lists the keys. Expressions are not evaluated. The reader opens only files that the scenario
    names, in its own folder or below.

    Parameters
    ----------
    path : str or Path
        Name of the file.

    Returns
    -------
    Scenario
        System, initial state, times and options of the run.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read or is invalid. The error message gives the file, the line, the key, the rule and the
        given value.

    Examples
    --------
    >>> scenario = pt.files.read_scenario("top.toml")
    >>> scenario.propagate(progress=False).times.tolist()
    [0.0, 0.5, 1.0, 1.5, 2.0]
    """
    path = Path(path)
    if path.suffix != ".toml":
        raise ValueError(f"path must end in .toml, got {quoted(path.name)}.")
    text = read_text(path, 4 * MAX_CHARACTERS)
    return parsed_scenario(text.replace("\r\n", "\n"), shortened(path), path.parent)


def parsed_scenario(text: str, name: str, folder: Path | None = None) -> Scenario:
    """Return the propagation that the text of a scenario describes; errors call it by the name.

    Without a folder it can name no file.
    """
    from poinsot.scenarios.builder import Parts
    from poinsot.scenarios.folder import Folder

    files = Folder(folder)
    parts = Parts(text, name, folder=files)
    system = parts.system()
    state = parts.state(system)
    spread = parts.values.get("ensemble") or {}
    provenance = {
        "title": parts.values.get("title") or None,
        "seed": spread.get("seed"),
        "scenario": text,
        "scenario_of": WITH_FILES if files.used else WHOLE,
        **({} if system.calendar or parts.calendar is None else {"calendar": parts.calendar}),
    }
    times = parts.times(system, state)
    return Scenario(name, system, state, times, parts.run(system), parts.outputs(), provenance, parts.plans(times))


def repetition(motion: Trajectory, name: str) -> Scenario:
    """Return the scenario that repeats the motion in a file: its own, or one of its system, initial state and times."""
    if not isinstance(motion.system, System):
        raise ValueError(f"{name} cannot be run again: {motion.system.not_rerunnable}")
    known = motion.provenance
    if known.get("scenario_of") == WHOLE:
        return parsed_scenario(known["scenario"], name)
    text = known.get("scenario_read") or known.get("scenario")
    text = text or scenario_of(motion.system, motion.run, motion.has_dense_output).text
    run = tomllib.loads(text)["run"]
    return Scenario(name, motion.system, motion.initial, motion.times, run, provenance=motion.provenance)
