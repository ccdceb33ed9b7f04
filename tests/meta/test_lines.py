"""Lines of code and chains of imports of small sources."""

import graphlib

import pytest
from tools.lines import code_lines, floors, import_graph, imported_modules, modules

TEXT = '''"""A module."""

# A comment.
LIMIT = 3  # with its reason
"""Largest number.

Of all.
"""

TEXT = """first

third"""


def function(x):
    """Return x."""
    return (
        # why
        x
    )
'''


def test_strings_below_constants_comments_and_blank_lines_are_no_code():
    assert code_lines(TEXT) == 7
    assert code_lines("") == 0


def test_imports_count_wherever_they_stand():
    text = "import p.a\nfrom p import b, name\ndef f():\n    from .c import x\n    from . import d\n    import q"
    assert imported_modules(text, "p.e", {"p", "p.a", "p.b", "p.c", "p.d", "p.e"}) == {"p", "p.a", "p.b", "p.c", "p.d"}


def test_floors_are_the_longest_chain():
    assert floors({"a": {"b", "d"}, "b": {"c"}, "c": {"d"}, "d": set()}) == ["a", "b", "c", "d"]
    assert floors({}) == []
    with pytest.raises(graphlib.CycleError):
        floors({"a": {"b"}, "b": {"a"}})


def test_modules_of_a_folder_have_their_names(tmp_path):
    source = tmp_path / "p"
    (source / "q").mkdir(parents=True)
    for name, text in {"__init__.py": "", "a.py": "import p.q.b", "q/__init__.py": "", "q/b.py": ""}.items():
        (source / name).write_text(text)
    files = modules(source)
    assert sorted(files) == ["p", "p.a", "p.q", "p.q.b"]
    assert import_graph(files) == {"p": set(), "p.a": {"p.q.b"}, "p.q": set(), "p.q.b": set()}
