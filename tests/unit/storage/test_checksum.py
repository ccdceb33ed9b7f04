"""CRC-32C against published values, the package google-crc32c, and texts that one bit changes."""

import sys

import google_crc32c
import numpy as np
import pytest

from poinsot.storage import checksum

PUBLISHED = {
    b"123456789": 0xE3069283,
    bytes(32): 0x8A9136AA,
    b"\xff" * 32: 0x62A8AB43,
    bytes(range(32)): 0x46DD794E,
    bytes(range(31, -1, -1)): 0x113FDB5C,
}
"""RFC 3720, appendix B.4; the first one is the check value of the CRC catalogue."""


@pytest.fixture(params=["google-crc32c", "NumPy"])
def crc32c(request, monkeypatch):
    if request.param == "NumPy":
        monkeypatch.setitem(sys.modules, "google_crc32c", None)
    checksum._fastest.cache_clear()
    yield lambda content: checksum.crc32c(np.frombuffer(content, np.uint8))
    checksum._fastest.cache_clear()


@pytest.mark.parametrize("content", PUBLISHED)
def test_published_values(crc32c, content):
    assert crc32c(content) == PUBLISHED[content]


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 15, 16, 17, 255, 1023, 4097, 100_003, 20_000_000])
def test_both_ways_agree(crc32c, size):
    content = np.random.default_rng(size).integers(0, 256, size, dtype=np.uint8)
    expected = google_crc32c.value(content.tobytes())
    assert crc32c(content) == expected
    content[size // 2] ^= 1
    assert crc32c(content) != expected
