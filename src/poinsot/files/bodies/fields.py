"""Gravity fields from tables of coefficients: PDS SHADR and ICGEM."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from poinsot.checked import checked
from poinsot.errors import real_array, refuse_nonpositive
from poinsot.files.keys import Entry, Keys
from poinsot.files.untrusted import MAX_BYTES, lazy_lines, read_text
from poinsot.mechanics.gravity_field import GravityField, whole_degree
from poinsot.printable import quoted, shortened
from poinsot.quantities import Array
from poinsot.shapes.shape import MAX_DEGREE

__all__ = ["read_field"]


MAX_NUMBER = 1e100
"""Largest number in a table: its products do not overflow."""

MAX_HEADER_CHARACTERS = 1_000_000
"""Characters."""


class _Table(NamedTuple):
    radius: float
    degree: int
    order: int
    normalized: bool
    rows: Iterable[tuple[int, list[str]]]  # number of the line, and n, m, C, S, ...


@checked
def read_field(
    path: str | Path, degree: int | None = None, *, mass: float, unit: float = 1.0, extent: float | None = None
) -> GravityField:
    """Return the gravity field in a table: SHADR of the PDS (comma-separated) or ICGEM (.gfc).

    Parameters
    ----------
    path : str or Path
        Name of a file of at most 64 MiB. The table states whether its coefficients are normalised.
    degree : int, optional
        Largest degree to read, from 2 to 80. Default: the degree of the table.
    mass : float
        Mass of the body in the unit of its moments. The function ignores the GM of the table, because G is known to
        2e-5 only.
    unit : float
        Unit of length of the table in the user's unit: 1000.0 for SHADR (km) if lengths are in m. ICGEM uses m.
    extent : float, optional
        Radius of a sphere about the centre of mass that contains the body, in the user's unit of length. A run counts
        the times at which an attractor is inside. Default: the reference radius of the table, which may be too small,
        for example if it is a mean radius. 0 means unknown: nothing is counted.

    Returns
    -------
    GravityField
        Field about the centre of mass, along the axes of the table.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read, a line is invalid, a coefficient is missing or repeated, the field varies with time,
        the degree exceeds the table, or `GravityField` raises an error.

    Examples
    --------
    >>> pt.files.read_field("g.tab", mass=1.0).degree
    2
    """
    text, factor = read_text(path, MAX_BYTES), float(real_array("unit", unit, ()))
    refuse_nonpositive("unit", factor)
    try:
        table = _icgem(text) if "end_of_head" in text else _shadr(text)
        last, highest = whole_degree(table.degree if degree is None else degree), min(table.degree, MAX_DEGREE)
        if not 2 <= last <= highest:
            raise ValueError(f"degree must be from 2 to {highest}, got {last}. The table has {table.degree}.")
        C, S = _coefficients(table, last)
        radius = factor * table.radius
        size = max(radius, 0.0) if extent is None else extent
        if table.normalized:
            return GravityField.from_normalized(mass, radius, C, S, size)
        return GravityField(last, mass, radius, C, S, size)
    except ValueError as error:
        raise ValueError(f"{shortened(path)}: {error}") from None


def _shadr(text: str) -> _Table:
    lines = ((k, line) for k, line in lazy_lines(text) if line.strip())
    header = _fields(next(lines, (0, ""))[1][:MAX_HEADER_CHARACTERS])
    if not 6 <= len(header) <= 8:
        raise ValueError(
            f"the header must have radius, GM, its error, degree, order and normalization, got {len(header)} fields."
        )
    radius, degree, order, flag = _number(1, header[0]), *(_whole(1, header[k]) for k in (3, 4, 5))
    if flag not in (0, 1):
        raise ValueError(f"the normalization must be 0 (none) or 1 (full), got {flag}.")
    if any(_number(1, turn) for turn in header[6:]):
        raise ValueError("the reference longitude and latitude must be 0, got others.")
    return _Table(radius, degree, order, flag == 1, ((k, _fields(line)) for k, line in lines))


ICGEM = Keys(("radius", "max_degree", "norm"))
"""Keys of the header of ICGEM with an influence on the result; other lines of the header are free."""


def _icgem(text: str) -> _Table:
    head, _, body = text.partition("end_of_head")
    words = (line.split() for _, line in lazy_lines(head.rpartition("begin_of_head")[2][:MAX_HEADER_CHARACTERS]))
    stated = (Entry(line[0], line[1], "the header") for line in words if len(line) >= 2 and ICGEM.resembles(line[0]))
    known = {key: entry.value for key, entry in ICGEM.by_key(stated).items()}
    for name in ("radius", "max_degree"):
        if name not in known:
            raise ValueError(f"the header must have {name}, got none.")
    norm = known.get("norm", "fully_normalized")
    if norm not in ("fully_normalized", "unnormalized"):
        raise ValueError(f"norm must be fully_normalized or unnormalized, got {quoted(norm)}.")
    degree = _whole(0, known["max_degree"])
    return _Table(_number(0, known["radius"]), degree, degree, norm == "fully_normalized", _static(head, body))


def _static(head: str, body: str) -> Iterator[tuple[int, list[str]]]:
    before = head.count("\n") + 1
    for k, line in lazy_lines(body):
        words = line.split() if k > 1 else []
        if not words:
            continue
        if words[0] != "gfc":
            raise ValueError(
                f"the field must be static, lines of gfc, got {quoted(words[0])} in line {before + k - 1}."
            )
        yield before + k - 1, words[1:]


def _coefficients(table: _Table, degree: int) -> tuple[Array, Array]:
    C, S = np.full((2, degree + 1, degree + 1), math.nan)
    C[0, 0], C[1, :2], S[0, 0], S[1, :2] = 1, 0, 0, 0  # where the table does not begin before degree 2
    seen: set[tuple[int, int]] = set()
    for line, fields in table.rows:
        if len(fields) < 4:
            raise ValueError(f"a line must have n, m, C and S, got {len(fields)} fields in line {line}.")
        n, m = _whole(line, fields[0]), _whole(line, fields[1])
        if not 0 <= m <= n <= table.degree:
            raise ValueError(f"n and m must have 0 <= m <= n <= {table.degree}, got {n}, {m} in line {line}.")
        if n > degree:
            continue
        if (n, m) in seen:
            raise ValueError(f"a coefficient must come once, got n = {n}, m = {m} again in line {line}.")
        seen.add((n, m))
        C[n, m], S[n, m] = _number(line, fields[2]), _number(line, fields[3])
    rows, columns = np.tril_indices(degree + 1)
    beyond = columns > table.order
    C[rows[beyond], columns[beyond]] = S[rows[beyond], columns[beyond]] = 0
    missing = np.argwhere(np.isnan(C[rows, columns]))
    if missing.size:
        place = int(missing[0, 0])
        raise ValueError(f"every coefficient must be given, got none for n = {rows[place]}, m = {columns[place]}.")
    return np.tril(C), np.tril(S)


def _fields(line: str) -> list[str]:
    return [field.strip() for field in line.split(",")] if "," in line else line.split()


def _place(line: int) -> str:
    return f"line {line}" if line else "the header"


def _number(line: int, field: str) -> float:
    """Return a finite number, also with the exponent of Fortran; line 0 is in the header of ICGEM."""
    try:
        number = float(field.upper().replace("D", "E"))
    except ValueError:
        number = math.nan
    if not abs(number) < MAX_NUMBER:
        raise ValueError(f"a number must be finite and below 1e100, got {quoted(field)} in {_place(line)}.")
    return number


def _whole(line: int, field: str) -> int:
    number: Any = _number(line, field)
    if number != int(number) or "_" in field:
        raise ValueError(f"degrees and orders must be whole numbers, got {quoted(field)} in {_place(line)}.")
    return int(number)
