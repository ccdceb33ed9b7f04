"""Summary and sketches of a motion, from its columns; `display.motion` formats them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from poinsot.display import motion as display
from poinsot.mechanics.environment import Environment
from poinsot.propagation.column_reader import ColumnReader
from poinsot.quantities import Array
from poinsot.storage.run_record import RunRecord

__all__ = ["lines", "shown_members", "sketches", "summary"]

ERRORS = ("norm_error", "tangency_error")


def summary(
    reader: ColumnReader,
    run: RunRecord,
    read: Callable[[Collection[str]], Mapping[str, Array]],
    environment: Callable[[], Environment],
) -> dict[str, str | float]:
    """Return the record of the method, of the errors and of formulas outside their validity.

    `read` returns columns by name.
    """
    if (recorded := reader.rows.summary) is not None:
        return run.entries | dict(recorded)
    drifts = [name for name, column in reader.table.items() if column.drift_of is not None]
    report = display.error_report(read((*ERRORS, *drifts)), bool(drifts))
    system, known = reader.system, (reader.state, environment())
    invalid, limited = (
        {name: at for name, at in each(*known).items() if np.any(at)} for each in (system.validity, system.limits)
    )
    errors = system.relative_errors(*known) if invalid else {}
    return run.entries | report | display.exceptions(invalid | limited, errors)


def lines(
    reader: ColumnReader, record: Mapping[str, str | float], dense: tuple[float, ...], failed: int
) -> tuple[str, dict[str, str]]:
    """Return the title and the lines of the summary of a motion."""
    rows, events = reader.rows, reader.rows.events
    return display.motion_summary(
        display.MotionDescription(
            system=repr(reader.system),
            time_unit=reader.system.units["time"],
            times=reader.times,
            record=record,
            members=reader.members if reader.is_ensemble else 0,
            failed=failed,
            store="" if rows.store is None else str(rows.store),
            dense=dense,
            events=[(event.kind, count) for event, count in zip(events.watched, events.counts, strict=True)],
            ends=events.ends,
        )
    )


def shown_members(reader: ColumnReader) -> list[int]:
    """Return the numbers of the members of an ensemble that a small plot shows; none for one motion."""
    return display.shown_members(reader.members) if reader.is_ensemble else []


def sketches(reader: ColumnReader, members: Sequence[int]) -> str:
    """Return small plots of some members of an ensemble, or of one motion and its errors."""
    unit, several = reader.system.units["time"], len(reader.system.of_bodies) > 1
    distance = np.linalg.norm(reader.read(["position"])["position"], axis=-1) if several else np.zeros(0)
    if members:
        name = "distance" if several else "rate"
        values = distance if several else np.hypot.reduce(reader.read(["omega_body"])["omega_body"], axis=-1)
        return display.sketch_of_members(name, reader.times, dict(zip(members, values, strict=True)), unit)
    q = np.zeros(0) if several else reader.read(["quaternion"])["quaternion"]
    shown = {"distance": distance} if several else {f"q{i}": q[:, i] for i in range(4)}
    symbols = {each.name: each.symbol for each in reader.system.integrals}
    drift = {f"drift of {symbols[name]}": values for name, values in reader.of_integrals("drift_").items()}
    errors = {"norm error": reader.read(["norm_error"])["norm_error"], **drift}
    return display.sketch_of_motion(reader.times, shown, errors, unit)
