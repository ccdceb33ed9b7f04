import numpy as np
import pytest

from poinsot.printable import described, kind_of, message_of, printable, quoted, shortened
from poinsot.suggestions import nearest


class Silent:
    def __repr__(self):
        raise KeyError("repr")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("a", "'a'"),
        (1.5, "1.5"),
        ((1, "b"), "(1, 'b')"),
        ("a" * 1000, f"'{'a' * 196}..."),
        (b"\x00" * 1000, ("b'" + "\\x00" * 60)[:197]),
        ([0.0] * 10**6, f"[{'0.0, ' * 39}0..."),
        ("\x1b\u202e\ud800", r"'\x1b\u202e\ud800'"),
        (np.eye(2), "array([[1., 0.], [0., 1.]])"),
        (Silent(), "(its repr raises KeyError)"),
        (10**5000, "(its repr raises ValueError)"),
    ],
    ids=range(10),
)
def test_an_argument_is_quoted_by_at_most_200_printable_characters(value, text):
    assert quoted(value).startswith(text)
    assert len(quoted(value)) <= 200
    assert quoted(value).isprintable()


def test_escapes_count_among_the_characters():
    assert shortened("\x1b" * 50) == "\\x1b" * 50
    assert shortened("\x1b" * 51) == ("\\x1b" * 50)[:197] + "..."


def test_plain_characters_are_not_escaped():
    assert printable("a\n\tb", unescaped="\n") == "a\n\\tb"


def test_classes_and_objects_are_described_by_the_name_of_the_class():
    long = type("N" * 1000, (), {})
    assert (described(int), described(1), kind_of(int)) == ("the class int", "int", "type")
    assert described(long) == f"the class {'N' * 197}..."
    assert kind_of(long()) == f"{'N' * 197}..."


def test_the_message_of_an_error_is_one_line():
    class MuteError(Exception):
        def __str__(self):
            raise ValueError("str")

    assert message_of(ValueError("a\n b\x07")) == r"a b\x07"
    assert message_of(MuteError()) == "MuteError (its str raises ValueError)"


def test_the_nearest_known_name_is_a_question():
    assert nearest("kane_dampr", ["rotor", "kane_damper"]) == " Did you mean 'kane_damper'?"
    assert nearest("wheel", ["kane_damper"]) == ""
