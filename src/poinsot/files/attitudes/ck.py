"""Attitudes in SPICE kernels: any frame that kernels know, and C-kernels of motions."""

from __future__ import annotations

import contextlib
import re
import struct
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from poinsot.algebra import quaternion as quat
from poinsot.atomic_write import new_file, unwritable
from poinsot.checked import checked
from poinsot.display.progress import Progress, bar
from poinsot.errors import optional, real_array
from poinsot.files.attitudes.attitude_format import AttitudeFormat
from poinsot.files.attitudes.attitude_table import AttitudeTable, calendar_of, rates_per_second, table_of
from poinsot.files.ccsds import FRAMES, body_and_reference
from poinsot.files.spice import ET, Kernels, loaded
from poinsot.kinematics.attitude import quaternion_from_matrix
from poinsot.printable import quoted, shortened
from poinsot.propagation.trajectory import Trajectory
from poinsot.quantities import Array, Times
from poinsot.records.calendar import SECONDS, Calendar

__all__ = ["read_ck", "spice_attitude", "write_ck"]

COVERAGE_MARGIN = 1e-3
"""Seconds by which a C-kernel reaches beyond the first and the last attitude."""

TIMES_PER_CALL = 50_000
"""Number of times in one call: SPICE takes about a second for them, and its process little memory."""

TICKS_PER_SECOND = 1_000_000
"""Ticks in a second of the clock of a C-kernel."""

OWN = "poinsot"
"""Name of the segments of kernels that poinsot writes."""

CLOCK = """KPL/SCLK

The clock of {frame}: microseconds of TDB. Written by poinsot.

\\begindata
SCLK_KERNEL_ID             = ( @{date} )
SCLK_DATA_TYPE_{clock}        = ( 1 )
SCLK01_TIME_SYSTEM_{clock}    = ( 1 )
SCLK01_N_FIELDS_{clock}       = ( 2 )
SCLK01_MODULI_{clock}         = ( 10000000000 {ticks} )
SCLK01_OFFSETS_{clock}        = ( 0 0 )
SCLK01_OUTPUT_DELIM_{clock}   = ( 1 )
SCLK_PARTITION_START_{clock}  = ( 0 )
SCLK_PARTITION_END_{clock}    = ( 1.0E+16 )
SCLK01_COEFFICIENTS_{clock}   = ( 0 {zero!r} 1 )
\\begintext
"""

FRAME = """KPL/FK

{frame}: axes of a body whose attitude a C-kernel contains. Written by poinsot.

\\begindata
FRAME_{frame} = {number}
FRAME_{number}_NAME = '{frame}'
FRAME_{number}_CLASS = 3
FRAME_{number}_CLASS_ID = {number}
FRAME_{number}_CENTER = {spacecraft}
CK_{number}_SCLK = {spacecraft}
CK_{number}_SPK = {spacecraft}
\\begintext
"""


# ------------------------------------------------------------------ reading


@checked
def spice_attitude(
    frame: str,
    times: Times,
    kernels: Sequence[str | Path],
    *,
    reference_frame: str = "J2000",
    calendar: Calendar = ET,
    progress: bool | None = None,
) -> AttitudeTable:
    """Return the attitude of a SPICE frame at given times, from a C-kernel or any other kernel.

    SPICE represents times as floats since 2000, with a resolution of 0.1 microseconds.

    Parameters
    ----------
    frame : str
        Name of the body axes, such as "IAU_MOON" or a frame of a frame kernel.
    times : array (n,) of float, str or astropy.time.Time
        Increasing times of the calendar, or dates with their time scale.
    kernels : sequence of paths
        All required files, for a C-kernel also its clock and its frames. Kernels loaded in spiceypy are ignored.
    reference_frame : str
        Name of an inertial frame of SPICE, whose J2000 is the ICRF.
    calendar : Calendar
        Calendar of the times. Default: seconds from 2000-01-01T12:00:00 TDB, which is SPICE's ET.
    progress : bool, optional
        True to show a progress bar during a long run. Default: True on a terminal.

    Returns
    -------
    AttitudeTable
        Attitudes, with rates if the kernels contain them.

    Raises
    ------
    OSError, ValueError, ImportError
        If a kernel is missing or invalid, a frame is unknown, the reference frame rotates, the kernels do not cover the
        times or contain rates at some of them only, or spiceypy is not installed.

    Examples
    --------
    >>> pt.files.spice_attitude("SC_BODY_1", ["2026-11-21T00:00:01 TAI"], ["m.bc", "m.tsc", "m.tf"])
    Attitudes of SC_BODY_1 in ICRF
      times: 1, ...
    """
    t = real_array("times", calendar.time(times), (None,))
    with loaded(kernels) as spice:
        shown = sys.stderr.isatty() if progress is None else progress
        return _table(spice, frame, reference_frame, t, calendar, shown)


def _table(
    spice: Kernels, frame: str, reference_frame: str, t: Array, calendar: Calendar, progress: Progress
) -> AttitudeTable:
    ets = np.atleast_1d(ET.converted(t, calendar))
    blocks = np.array_split(ets, max(-(-ets.size // TIMES_PER_CALL), 1))
    answers = []
    with bar("times", ets.size, progress) as advance:
        for block in blocks:
            answers.append(spice.ask("turned", frame, reference_frame, times=block)[1])
            advance(block.size)
    matrices, rates = map(np.concatenate, zip(*answers, strict=True))
    q = quaternion_from_matrix(np.swapaxes(matrices, -1, -2))
    known = np.isfinite(rates[:, 0])
    if np.any(known) and not np.all(known):
        with_rates, without = (str(calendar.date(t[int(np.argmax(one))]).isot) for one in (known, ~known))
        raise ValueError(
            f"kernels must have rates of {quoted(frame)} at all times or at none, got rates at {with_rates} and none "
            f"at {without}. Ask for the times with rates and the times without rates in two calls."
        )
    omega = quat.rotate(quat.conjugate(q), rates) * SECONDS[calendar.unit] if np.all(known) else None
    named = "ICRF" if reference_frame.upper() == "J2000" else reference_frame.upper()
    return AttitudeTable(t, q, omega, calendar, named, frame.upper())


@checked
def read_ck(path: str | Path, *, calendar: Calendar = ET) -> AttitudeTable:
    """Return the attitudes in a C-kernel at its own instants.

    The files of the same name with .tsc and .tf define clock and frame. The kernel must have one segment, of type 3,
    relative to an inertial frame. The reader omits the extra millisecond at both ends of a kernel that poinsot wrote.
    The resolution of the times is 0.1 microseconds.

    Parameters
    ----------
    path : str or Path
        Name of the C-kernel.
    calendar : Calendar
        Calendar of the times. Default: SPICE's ET.

    Returns
    -------
    AttitudeTable
        Attitudes at the instants of the kernel.

    Raises
    ------
    OSError, ValueError, ImportError
        If a kernel is missing, invalid or of another kind, or spiceypy is not installed.

    Examples
    --------
    >>> pt.files.read_ck("m.bc").times.size
    9
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"No such file: {shortened(path)}")
    kernels = [path, path.with_suffix(".tsc"), path.with_suffix(".tf")]
    for kernel in kernels[1:]:
        if not kernel.is_file():
            raise FileNotFoundError(
                f"{shortened(path)} must have the kernels of its clock and its frame in its folder, got no "
                f"{shortened(kernel.name)}. spice_attitude accepts kernels from any folder."
            )
    with loaded(kernels) as spice:
        (frame, reference), (ets,) = spice.ask("instants", str(path), OWN)
        return _table(spice, frame, reference, np.asarray(calendar.converted(ets, ET)), calendar, False)


# ------------------------------------------------------------------ writing


@checked
def write_ck(
    motion: Trajectory | AttitudeTable,
    path: str | Path,
    *,
    calendar: Calendar | None = None,
    reference_frame: str | None = None,
    body_frame: str | None = None,
    spacecraft: int = -1000,
    rates: bool = True,
    overwrite: bool = False,
) -> tuple[Path, Path, Path]:
    """Write the attitudes of a motion as a SPICE C-kernel of type 3, with the files of its clock and its frame.

    SPICE rotates between attitudes at a constant rate, and interpolates rates linearly. poinsot extends the kernel by
    one millisecond at both ends with constant rates, so that converted instants of another program are inside its span.

    Parameters
    ----------
    motion, calendar, rates, overwrite
        Same as in `write_aem`.
    path : str or Path
        Name of the C-kernel, which ends in .bc. The files of clock and frame have the same name with .tsc and .tf.
    reference_frame : str, optional
        Name of the space axes. A C-kernel refers to the ICRF, which SPICE calls J2000.
    body_frame : str
        Name of the body frame: up to 26 letters, digits and underscores.
    spacecraft : int
        SPICE number of the spacecraft, negative. The numbers of frame and structure are a thousand times this number.

    Returns
    -------
    (Path, Path, Path)
        Paths of the C-kernel, the clock and the frame.

    Raises
    ------
    TypeError, ValueError, OSError, ImportError
        If an argument is invalid, the motion is an ensemble or has fewer than two times, a file exists, or spiceypy is
        not installed.

    Examples
    --------
    >>> calendar = pt.Calendar("2026-11-21T00:00:00", "UTC")
    >>> paths = pt.files.write_ck(motion, "new.bc", calendar=calendar, reference_frame="ICRF")
    >>> [path.name for path in paths]
    ['new.bc', 'new.tsc', 'new.tf']
    """
    spice = optional("spiceypy", "SPICE kernels")
    table = table_of(motion, calendar, reference_frame, body_frame)
    frame, path = table.body_frame.upper(), Path(path)
    _check_arguments(table, frame, path, spacecraft)
    instants = calendar_of(table).date(table.times)
    first = instants[0].tdb
    first.precision = 9
    begin = Calendar(str(first.isot), "TDB")
    at_first = ET.time(f"{begin.zero} TDB")
    zero = at_first - COVERAGE_MARGIN  # of the clock
    seconds = np.asarray(begin.time(instants)) + (at_first - zero)
    names = {"frame": frame, "spacecraft": spacecraft, "number": 1000 * spacecraft, "clock": -spacecraft}
    others = (path.with_suffix(".tsc"), path.with_suffix(".tf"))
    with contextlib.ExitStack() as stack:
        kernel, clock, frames = (stack.enter_context(new_file(name, overwrite)) for name in (path, *others))
        clock.write_text(
            CLOCK.format(**names, ticks=TICKS_PER_SECOND, zero=zero, date=begin.zero[:10]), encoding="ascii"
        )
        frames.write_text(FRAME.format(**names), encoding="ascii")
        with _opened(spice, kernel) as handle:
            _write_segment(spice, handle, table, seconds, 1000 * spacecraft, rates)
        if kernel.stat().st_size < _size_stated_in(kernel):
            raise OSError(unwritable(path, "SPICE wrote a part of it without a word") + " Is the disk full?")
    return path, *others


def _check_arguments(table: AttitudeTable, frame: str, path: Path, spacecraft: int) -> None:
    if path.suffix != ".bc":
        raise ValueError(f"path must end in .bc, got {quoted(path.name)}.")
    if FRAMES[table.reference_frame] != "ICRF":
        raise ValueError(f"reference_frame must be the ICRF for a C-kernel, got {table.reference_frame}.")
    body_and_reference(table.reference_frame, frame, "reference_frame and body_frame")
    if not re.fullmatch(r"[A-Z]\w{0,25}", frame, re.ASCII):
        raise ValueError(f"body_frame must be up to 26 letters, digits and underscores, got {quoted(frame)}.")
    if not -2_000_000 < spacecraft < 0:
        raise ValueError(f"spacecraft must be a negative number above -2000000, got {spacecraft}.")
    if table.times.size < 2:
        raise ValueError(f"motion must have two times or more for a C-kernel, got {table.times.size}.")


@contextlib.contextmanager
def _opened(spice: Any, path: Path) -> Iterator[int]:
    try:
        handle = spice.ckopn(str(path), OWN, 0)
        try:
            yield handle
        finally:
            spice.ckcls(handle)
    except spice.utils.exceptions.SpiceyError as error:
        raise ValueError(f"motion must be one that a C-kernel can represent, got {error.short} from SPICE.") from None


def _size_stated_in(kernel: Path) -> int:
    """Return the bytes before the first free number of a file, which its first record has at byte 84 (SPICE, "DAF")."""
    with kernel.open("rb") as stream:
        (free,) = struct.unpack_from("=i", stream.read(1024), 84)
    return 8 * (int(free) - 1)


def _write_segment(spice: Any, handle: int, table: AttitudeTable, seconds: Array, number: int, rates: bool) -> None:
    """Write the attitudes, as quaternions of the matrices from space to body, and rates along the space axes."""
    known = rates_per_second(table, rates)
    omega = np.zeros((seconds.size, 3)) if known is None else known
    ends = [
        quat.product(table.quaternion[i], _small_turn(omega[i] * t))
        for i, t in ((0, -COVERAGE_MARGIN), (-1, COVERAGE_MARGIN))
    ]
    q = np.concatenate([ends[:1], table.quaternion, ends[1:]])
    along_space = quat.rotate(q, np.concatenate([omega[:1], omega, omega[-1:]]))
    ticks = TICKS_PER_SECOND * np.concatenate([[0.0], seconds, [seconds[-1] + COVERAGE_MARGIN]])
    span, has_rates = (ticks[0], ticks[-1]), known is not None
    spice.ckw03(
        handle, *span, number, "J2000", has_rates, OWN, ticks.size, ticks, quat.conjugate(q), along_space, 1, ticks[:1]
    )


def _small_turn(vector: Array) -> Array:
    """Return the quaternion of a rotation by a vector."""
    half = np.linalg.norm(vector) / 2
    return np.append(np.cos(half), np.sinc(half / np.pi) * vector / 2)


class Ck(AttitudeFormat):
    """C-kernels of SPICE, of type 3, with clock and frame."""

    title = "SPICE CK"
    suffixes = (".bc",)
    in_python = "pt.files.spice_attitude, with the kernels of its clock and its frame"
    conventions = (
        "scalar first",
        "conjugate of the quaternion in poinsot (matrix from space to body)",
        "rad/s along space",
    )
    read, write = staticmethod(read_ck), staticmethod(write_ck)
    mark = re.compile(rb"\ADAF/CK")
