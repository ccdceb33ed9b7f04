"""The format of an attitude file from its name and its first bytes."""

from pathlib import Path

import pytest

from poinsot.files.attitudes.attitude_format import attitude_formats, format_of

HEADS = {
    "AEM": b"CCSDS_AEM_VERS = 1.0\nCREATION_DATE = 2026-01-01T00:00:00\n",
    "STK": b"stk.v.12.0\nBEGIN Attitude\n",
}


@pytest.mark.parametrize("name", ["motion.aem", "MOTION.AEM", "a.b.aem"])
def test_suffixes_have_any_case(name):
    assert "AEM" in format_of(Path(name)).title


def test_name_without_a_format():
    assert format_of(Path("motion.txt")) is None


@pytest.mark.parametrize("word", HEADS)
def test_first_bytes_identify_one_format(word):
    found = [each.title for each in attitude_formats() if each.sniff(HEADS[word])]
    assert len(found) == 1
    assert word in found[0]
