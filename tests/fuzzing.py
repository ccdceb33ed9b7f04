"""Files as strangers, broken disks and old programs make them: from a good one by seeded changes."""

import re
import struct

import numpy as np

DOUBLES = (0.0, -0.0, -1.0, 1e300, -1e300, 5e-324, np.inf, -np.inf, np.nan, 2.0**53, 0.5)
WHOLES = (0, 1, -1, 2, 127, 255, 65535, 2**31 - 1, -(2**31), 2**31 - 2, 1000, 641, 642)
TEXTS = (
    b"0", b"-1", b"1e999", b"-1e308", b"5e-324", b"nan", b"inf", b"9" * 400, b"1" + b"0" * 30, b"0x10", b"1_0", b"",
    b"2026-02-30T25:61:61", b"9999-12-31T23:59:59", b"\x1b[31m", b"\xff\xfe", b"\x00", b"[" * 300, b'"', b"'''", b"{",
    b"\xe2\x80\xae", b"e", b".", b"-", b"../../../etc/passwd", b"/dev/zero", b"true", b"\r", b"\n\n", b"=",
    b"<!DOCTYPE a>",
)  # fmt: skip


def mutant(content, rng, text):
    """The bytes of a file with one to four changes, of a kind for text or for binary files."""
    ways = (*COMMON, *(TEXTUAL if text else BINARY))
    for _ in range(rng.integers(1, 5)):
        if content:
            content = ways[rng.integers(len(ways))](bytes(content), rng)
    return content


def place(content, rng):
    return int(rng.integers(len(content)))


def cut(content, rng):
    return content[: place(content, rng)]


def without(content, rng):
    i = place(content, rng)
    return content[:i] + content[i + int(rng.integers(1, 600)) :]


def twice(content, rng):
    i = place(content, rng)
    part = content[i : i + int(rng.integers(1, 600))]
    return content[:i] + part * int(rng.integers(2, 5)) + content[i:]


def other_bytes(content, rng):
    changed = bytearray(content)
    for i in rng.integers(0, len(content), rng.integers(1, 20)):
        changed[i] = rng.integers(256)
    return bytes(changed)


def moved(content, rng):
    i, j = place(content, rng), place(content, rng)
    part = content[i : i + int(rng.integers(1, 300))]
    return content[:j] + part + content[j + len(part) :]


def word(content, rng):
    """A double or a whole number at a multiple of 4 or 8 bytes, mostly in the first kilobytes, is an extreme one."""
    kind = "<>"[rng.integers(2)] + "dqi"[rng.integers(3)]
    value = rng.choice(DOUBLES) if kind[1] == "d" else int(rng.choice(WHOLES))
    new = struct.pack(kind, value)
    end = len(content) if rng.integers(2) else min(len(content), 3072)
    i = int(rng.integers(max(end // 4, 1))) * 4
    return content[:i] + new + content[i + len(new) :]


def token(content, rng):
    """A number or a word is another one."""
    found = list(re.finditer(rb"[^\s,=<>\"\[\]]+", content))
    if not found:
        return content
    here = found[rng.integers(len(found))]
    return content[: here.start()] + TEXTS[rng.integers(len(TEXTS))] + content[here.end() :]


def lines(content, rng):
    """A line is gone, there again elsewhere, or there many times."""
    rows = content.split(b"\n")
    i, j = rng.integers(len(rows)), rng.integers(len(rows))
    row = rows[i]
    if rng.integers(2):
        del rows[i]
    rows[j:j] = [row] * int(rng.choice([0, 1, 1, 50]))
    return b"\n".join(rows)


COMMON = (cut, without, twice, other_bytes, moved)
BINARY = (word, word, word, word)
TEXTUAL = (token, token, token, token, lines, lines)
