"""CRC-32C, the checksum of the blocks in stores (RFC 3720, appendix B.4).

The package google-crc32c computes it with instructions of the processor, some 15 times as fast as the NumPy version.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

__all__ = ["crc32c"]

Registers = NDArray[np.uint32]

POLYNOMIAL = 0x82F63B78
"""The polynomial of Castagnoli, lowest bit first."""

ONES = 2**32 - 1

MAX_PIECES = 2**12
"""Most pieces of a text whose registers are computed side by side."""


def crc32c(content: NDArray[np.uint8]) -> int:
    """Return the CRC-32C of bytes."""
    return _fastest()(content)


@functools.cache
def _fastest() -> Callable[[NDArray[np.uint8]], int]:
    """Return the function of google-crc32c, of the extra `stores`, or the one below."""
    try:
        import google_crc32c
    except ImportError:
        return _by_pieces

    def of_package(content: NDArray[np.uint8]) -> int:
        whole = content.view()
        whole.flags.writeable = False  # google_crc32c accepts no other
        return int(google_crc32c.value(whole))

    return of_package


def _by_pieces(content: NDArray[np.uint8]) -> int:
    """Return the CRC-32C of bytes, as pieces of equal length side by side.

    The register is linear in the text: the register after two pieces is the sum modulo 2 of the second one's and of the
    first one's after as many zeros. Zeros in front leave the register 0, and so fill the first piece. The register of
    CRC-32C starts with 32 ones, which are added after the zeros of the whole text.
    """
    count = min(1 << (content.size.bit_length() // 2), MAX_PIECES)
    length = max(-(-content.size // count), 1)
    filled = np.zeros(count * length, np.uint8)
    filled[filled.size - content.size :] = content
    registers, shift = _registers(filled.reshape(count, length)), _zeros(length)
    while registers.size > 1:
        registers = _applied(shift, registers[::2]) ^ registers[1::2]
        shift = _applied(shift, shift)
    start = _applied(_zeros(content.size), np.full(1, ONES, np.uint32))
    return (registers ^ start).item() ^ ONES


def _registers(pieces: NDArray[np.uint8]) -> Registers:
    """Return the registers after each piece, from 0."""
    table, registers = _table(), np.zeros(len(pieces), np.uint32)
    for column in np.ascontiguousarray(pieces.T):
        registers = table[(registers ^ column) & 0xFF] ^ (registers >> 8)
    return registers


@functools.cache
def _table() -> Registers:
    """Return the register after each byte."""
    registers: Registers = np.arange(256, dtype=np.uint32)
    for _ in range(8):
        lowest = registers & np.uint32(1)
        registers = (registers >> np.uint32(1)) ^ lowest * np.uint32(POLYNOMIAL)
    return registers


def _zeros(count: int) -> Registers:
    """Return the registers after some zero bytes, from registers of a single one, the lowest first."""
    bits = np.uint32(1) << np.arange(32, dtype=np.uint32)
    result: Registers = bits
    power = _table()[bits & 0xFF] ^ (bits >> 8)
    while count:
        result = _applied(power, result) if count & 1 else result
        power, count = _applied(power, power), count >> 1
    return result


def _applied(images: Registers, registers: Registers) -> Registers:
    """Return the images of registers under a linear map that is given by the images of single ones."""
    result = np.zeros_like(registers)
    for bit, image in enumerate(images):
        result ^= np.where((registers >> np.uint32(bit)) & 1, image, np.uint32(0))
    return result
