"""The checks of imports find the faults that they look for, in small sources."""

from tools.lines import imported_modules

from imports import circles, set_elsewhere, upward


def test_cycles_upward_imports_and_globals_set_elsewhere_are_found():
    """A circle through a function and one through TYPE_CHECKING; an import upwards and one across."""
    texts = {
        "p.a": "def f():\n    from p.b import x",
        "p.b": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import p.c",
        "p.c": "from . import a",
        "p.d": "import p.a",
    }
    edges = {name: imported_modules(text, name, texts) for name, text in texts.items()}
    assert circles(edges) == [["p.a", "p.b", "p.c"]]
    assert upward(edges, [["p.a"], ["p.b", "p.d"], ["p.c"]]) == ["p.c -> p.a", "p.d -> p.a"]
    assert upward({"p.b": {"p.d"}}, [["p.b", "p.d"]]) == ["p.b -> p.d"]
    hatch = "from p import a\nimport p.b\nstart: int\nend: int = 1\na.engine = end\np.b.engine = end\nstart.x = 1"
    assert [*set_elsewhere(hatch)] == ["start", "a.engine", "p.b.engine"]
