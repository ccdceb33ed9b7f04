"""Keys of files: every format treats unknown, misspelled, misplaced and repeated keys alike."""

import re
import warnings

import numpy as np
import pytest

import poinsot as pt
from poinsot.files.keys import Entry, Keys
from tumbling import columns
from unit.files.attitudes import test_aem, test_apm, test_quaternion_csv, test_stk
from unit.files.orbits import test_oem, test_tle

KEYS = Keys(("REF_FRAME", "EPOCH"), ("OBJECT_NAME",), elsewhere=("ANGVEL_X",), repeated=("COMMENT",))


def entries(*keys):
    return [Entry(key, str(i), f"a.x, line {i}") for i, key in enumerate(keys, start=1)]


def test_known_keys_pass():
    found = KEYS.by_key(entries("EPOCH", "OBJECT_NAME", "COMMENT", "COMMENT", "USER_DEFINED_X", "USER_DEFINED_X"))
    assert {key: entry.value for key, entry in found.items()} == {
        "EPOCH": "1", "OBJECT_NAME": "2", "COMMENT": "4", "USER_DEFINED_X": "6"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        (("EPOCH", "EPOCH"), "a.x, line 2 must not repeat EPOCH, got '2' after '1'. Remove one of them."),
        (("REF_FRAM",), "a.x, line 1 must have a key of the format, got 'REF_FRAM'. Did you mean 'REF_FRAME'?"),
        (("epoch",), "a.x, line 1 must have a key of the format, got 'epoch'. Did you mean 'EPOCH'?"),
        (("ANGVEL_XX",), "a.x, line 1 must have a key of the format, got 'ANGVEL_XX'. Did you mean 'ANGVEL_X'?"),
        (
            ("ANGVEL_X",),
            "a.x, line 1 must have a key of its block and version, got 'ANGVEL_X'. Move it to its block, or remove it.",
        ),
    ],
)
def test_keys_that_could_change_the_result_are_errors(keys, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        KEYS.by_key(entries(*keys))


@pytest.mark.parametrize(("key", "hint"), [("FOO", ""), ("OBJECT_NAM", " Did you mean 'OBJECT_NAME'?")])
def test_other_unknown_keys_are_ignored_with_a_warning(key, hint):
    sentence = f"a.x, line 1 should have a key of the format, got {key!r}, which is ignored.{hint}"
    with pytest.warns(UserWarning, match=f"^{re.escape(sentence)}$"):
        KEYS.by_key(entries(key))


# ------------------------------------------------------------------ every format


def one_tag_a_line(text):
    return text.replace("\n", "").replace("<", "\n<").lstrip()


def message_reader(text, _):
    return pt.files.omm_orbit(text, 0.0, 3000.0)


def file_reader(read, name):
    def reader(text, folder):
        (folder / name).write_text(text)
        return read(folder / name)

    return reader


NUMBERS = columns("QUATERNION/ANGVEL")
OEM = test_oem.OPENING + test_oem.metadata(STOP_TIME=test_oem.dated(480)) + test_oem.lines(last=4)
APM = file_reader(pt.files.read_apm, "a.apm")
FILES = {
    "aem": (file_reader(pt.files.read_aem, "a.aem"), test_aem.WHOLE),
    "aem.xml": (
        file_reader(pt.files.read_aem, "a.aem"),
        one_tag_a_line(test_aem.as_xml("QUATERNION/ANGVEL", NUMBERS)),
    ),
    "apm": (APM, test_apm.HEAD + test_apm.QUAT + test_apm.ANGVEL + test_apm.INERTIA.partition("MAN_START")[0]),
    "apm 1": (APM, test_apm.V1.partition("MAN_EPOCH")[0]),
    "oem": (file_reader(pt.files.read_oem, "a.oem"), OEM),
    "oem.xml": (file_reader(pt.files.read_oem, "a.oem"), one_tag_a_line(test_oem.as_xml())),
    "omm": (message_reader, test_tle.as_kvn(test_tle.MESSAGE)),
    "omm.xml": (message_reader, one_tag_a_line(test_tle.as_xml(test_tle.MESSAGE))),
    "stk": (file_reader(pt.files.read_stk_attitude, "a.a"), test_stk.WHOLE),
    "csv": (
        file_reader(pt.files.read_quaternion_csv, "a.csv"),
        "# reference_frame: ICRF\n" + test_quaternion_csv.WHOLE,
    ),
}
KVN = re.compile(r"(?P<begin>(# )?)(?P<key>[A-Za-z]\w+)(?P<between> = |: | +)(?P<value>.+)")
XML = re.compile(r"(?P<begin><)(?P<key>[A-Z][A-Z_\d]+)(?P<between>( units=\"[^\"]*\")?>)(?P<value>.+)")
MOST = 24
"""Keys of a file that are tried; the rows of messages in XML repeat them."""


def statements(name):
    """Each statement of a file: the text before it, a function that makes its text, its key, and the text after it."""
    pattern = XML if name.endswith("xml") else KVN
    lines = FILES[name][1].split("\n")
    found = 0
    for i, line in enumerate(lines):
        match = pattern.fullmatch(line)
        if not match or found == MOST or match["key"] in ("COMMENT", "BEGIN", "END") or "_VERS" in line:
            continue
        found += 1
        last = i + 2 if pattern is XML else i + 1

        def made(key, value=match["value"], match=match):
            end = f"\n</{key}>" if match["begin"] == "<" else ""
            return f"{match['begin']}{key}{match['between']}{value}{end}"

        yield "\n".join([*lines[:i], ""]), made, match["key"], "\n".join(["", *lines[last:]])


def outcome(reader, text, folder):
    """Whether a file is read, read with a warning, or an error."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            reader(text, folder)
        except ValueError:
            return "error"
    return "warning" if any(one.category is UserWarning for one in caught) else "read"


@pytest.mark.parametrize("name", FILES)
def test_no_change_of_a_key_passes_silently(tmp_path, name):
    reader, whole = FILES[name]
    assert outcome(reader, whole, tmp_path) == "read"
    tried = 0
    for before, made, key, after in statements(name):
        short = key[: len(key) // 2] + key[len(key) // 2 + 1 :]
        other = key.swapcase()
        both = made(key)
        assert outcome(reader, before + both + "\n" + both + after, tmp_path) == "error", key
        assert outcome(reader, before + both + "\n" + made(key, "7") + after, tmp_path) == "error", key
        assert outcome(reader, before + made(key, "7") + "\n" + both + after, tmp_path) == "error", key
        assert outcome(reader, before + made(short) + after, tmp_path) != "read", key
        if name not in ("stk", "csv"):  # whose keywords may be in any case
            assert outcome(reader, before + made(other) + after, tmp_path) != "read", key
        if name != "csv":  # in which other comments are free
            assert outcome(reader, before + both + "\n" + made("FOO_BAR_BAZ", "7") + after, tmp_path) != "read", key
        tried += 1
    assert tried >= 4


FRAMES = {
    "aem": ("REF_FRAME_A = EME2000", "ANGVEL_FRAME = SC_BODY_1"),
    "aem.xml": ("<REF_FRAME_A>EME2000", "<ANGVEL_FRAME>SC_BODY_1"),
    "apm": ("INERTIA_REF_FRAME = SC_BODY_1", "ANGVEL_FRAME = SC_BODY_1"),
    "apm 1": ("Q_FRAME_A = EME2000", "Q_FRAME_B = SC_BODY_1"),
    "csv": ("reference_frame: ICRF",),
}


@pytest.mark.parametrize("name", FRAMES)
def test_axes_in_any_case(tmp_path, name):
    reader, whole = FILES[name]
    right = reader(whole, tmp_path)
    for line in FRAMES[name]:
        key, frame = re.fullmatch(r"(.*?)(\w+)", line).groups()
        found = reader(whole.replace(line, key + frame.lower()), tmp_path)
        for one, other in ((right, found),) if isinstance(right, pt.files.AttitudeTable) else ((right[0], found[0]),):
            np.testing.assert_array_equal(other.quaternion, one.quaternion)
            np.testing.assert_array_equal(other.omega_body, one.omega_body)
            assert (other.reference_frame, other.body_frame) == (one.reference_frame, one.body_frame)
