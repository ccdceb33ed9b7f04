"""Record of a run: method, order, steps and tolerance, and the versions of the packages that computed it."""

from __future__ import annotations

import functools
import json
import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from enum import StrEnum
from typing import Any

from typing_extensions import override

from poinsot.immutable import read_only

OF_CHUNK = ("order", "tolerance", "steps", "kernel", "lanes")
"""Entries of a chunk of members; all but the steps are equal in all chunks of a run."""


class Method(StrEnum):
    """Method that computed a trajectory."""

    TAYLOR = "Taylor"
    TAYLOR_OF_MEMBERS = "Taylor, members in batches"
    VARIATIONAL = "Taylor, with variational equations"
    CLOSED_FORM = "closed form"
    TABLE = "table"
    ONE_OF_TWO = "Taylor, one of two bodies"


@dataclass(frozen=True)
class RunRecord:
    """Record of the run that computed a trajectory.

    Attributes
    ----------
    method : Method
    formulation, precision : str
    tolerance : float
        Of the integrator, relative, per step.
    order, steps : int
        Of the Taylor expansion; steps taken in both directions together.
    wall_time : float
        Seconds, without the building of the integrator.
    versions : mapping
        Of the package and of what computed.
    kernel : str
        "looped" or "cuda", of earlier versions also "heyoka"; empty if nothing was integrated.
    lanes : int
        How many members it integrates at a time.
    """

    method: Method
    formulation: str
    precision: str
    tolerance: float
    order: int
    steps: int
    wall_time: float
    versions: Mapping[str, str] = field(default_factory=dict)
    kernel: str = ""
    lanes: int = 0

    @classmethod
    def of(
        cls,
        totals: tuple[float, int, int, float, str, int],
        method: Method,
        formulation: str,
        precision: str = "double",
    ) -> RunRecord:
        """Return the record of a run, from the totals of its report."""
        tolerance, order, steps, wall_time, kernel, lanes = totals
        own = (tolerance, order, steps, wall_time, Versions(), kernel, lanes)
        return cls(method, formulation, precision, *own)

    @property
    def of_chunk(self) -> dict[str, Any]:
        """Attributes of a chunk of members about its run, which `with_chunks` reads."""
        return {name: getattr(self, name) for name in OF_CHUNK}

    def with_chunks(self, chunks: Sequence[Mapping[str, Any]]) -> RunRecord:
        """Return the record of the run that computed chunks, from their attributes."""
        if not chunks:
            return self
        first = {name: chunks[0][name] for name in OF_CHUNK}
        return replace(self, **first | {"steps": sum(each["steps"] for each in chunks)})

    @property
    def entries(self) -> dict[str, str | float]:
        """Entries of a summary: everything but the versions."""
        own = {key: value for key, value in asdict(self).items() if key != "versions"}
        return own | {"method": str(self.method)}

    def attributes(self, failures: Mapping[int, str]) -> dict[str, str | float]:
        """Return the attributes of a dataset, with the reasons why members stopped, without the wall time."""
        return {
            **{key: value for key, value in self.entries.items() if key != "wall_time"},
            **({"failures": json.dumps(dict(failures))} if failures else {}),
            **{f"version_{name}": version for name, version in self.versions.items()},
        }


class Versions(Mapping[str, str]):
    """The versions of this process, which are looked up when one of them is read first."""

    @override
    def __getitem__(self, name: str) -> str:
        return versions()[name]

    @override
    def __iter__(self) -> Iterator[str]:
        return iter(versions())

    @override
    def __len__(self) -> int:
        return len(versions())

    @override
    def __repr__(self) -> str:
        return repr(versions())

    @override
    def __reduce__(self) -> tuple[type[dict[str, str]], tuple[dict[str, str]]]:
        return dict, (dict(versions()),)


@functools.cache
def versions() -> dict[str, str]:
    """Return the versions of the package and of its numerical libraries."""
    from importlib import metadata

    from poinsot import __version__

    packages = {name: metadata.version(name) for name in ("llvmlite", "numpy", "scipy")}
    return read_only({"poinsot": __version__, **packages, "python": platform.python_version()})
