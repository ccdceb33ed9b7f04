"""What a notebook shows of everything that is public: short, whole markup, without a request, and nothing runs."""

import html
import inspect
import re
import warnings
from html.parser import HTMLParser

import numpy as np
import pytest

import poinsot as pt
from kinds.results import DESCRIPTIONS, RESULTS
from public_calls import BODY, START, TIMES, TOP, ensemble, free, motion, pair_motion, public_calls

COMPILED_LONG = {"both ways, in quadruple precision"}
"""A trajectory like others, whose kernel takes seconds to compile."""


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """All records and results, by their names."""
    folder = tmp_path_factory.mktemp("calls")
    calls = public_calls(folder)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a periapsis within a body
        made = {name: kind(**given) for name, (kind, given) in calls.items() if inspect.isclass(kind)}
    made |= {f"result: {name}": RESULTS[name](folder) for name in sorted(RESULTS.keys() - DESCRIPTIONS - COMPILED_LONG)}
    made |= {"System": TOP, "System of two bodies": pair_motion().system, "system of a table": motion().system}
    return {name: thing[0] if isinstance(thing, list) else thing for name, thing in made.items() if thing is not None}


class Markup(HTMLParser):
    """The tags of a page, their attributes, and whether each is closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.attributes = [], set(), {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        self.attributes |= dict(attributes)
        self.open += [tag] * (tag != "br")

    def handle_startendtag(self, tag, attributes):
        self.tags.add(tag)
        self.attributes |= dict(attributes)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


PLAIN = {"Calendar", "LagrangePointPath"}
"""Values that have one line."""


def test_every_public_thing_has_a_short_summary(shown):
    assert len(shown) > 100
    for name, thing in shown.items():
        text = repr(thing)
        assert "object at 0x" not in text, (name, text)
        assert not re.search(r"[1-9](?:[.]?\d){11,}", text), (name, text)
        assert len(text.splitlines()) < 20, name
        assert max(map(len, text.splitlines())) < 800, (name, text)


def test_every_public_thing_has_a_table_that_asks_for_nothing(shown):
    """No script, no address, no style from elsewhere; the page is whole."""
    for name, thing in shown.items():
        if type(thing).__name__ in PLAIN:
            continue
        markup = Markup(thing._repr_html_())
        assert markup.open == [], name
        assert not markup.tags & {"script", "link", "img", "iframe", "object", "embed", "style", "a", "image", "use"}
        assert not markup.attributes.keys() & {"src", "href", "srcset", "data", "xlink:href", "onload", "onclick"}
        assert "url(" not in str(markup.attributes)
        assert len(thing._repr_html_()) < 60_000, name


HOSTILE = "<script>alert('&')</script>\"x"


def test_words_of_others_are_no_markup():
    """Units, names of parts and titles come from files."""
    system = pt.System(BODY, *TOP.forces, units={"time": HOSTILE, "inertia": HOSTILE})
    moved = pt.propagate(system, START, TIMES)
    for thing in (system, moved, ensemble(), moved[0], BODY):
        assert "script" not in Markup(thing._repr_html_()).tags
    assert html.escape(HOSTILE) in moved._repr_html_()
    assert html.escape(HOSTILE) in system._repr_html_()


def curve_points(text):
    """The points of each curve of the small plots in a page, and the colours."""
    return [
        np.array([[float(x) for x in pair.split(",")] for pair in points.split()])
        for points in re.findall(r'<polyline[^>]* points="([^"]*)"', text)
    ]


def test_a_motion_is_drawn_with_its_proof():
    """The four components of q, one after another, and the errors, whose largest so far never sink."""
    moved = free()
    q, errors = curve_points(moved._repr_html_())[:4], curve_points(moved._repr_html_())[4:]
    low, high = moved.quaternion.min(), moved.quaternion.max()
    for i, points in enumerate(q):
        heights = (moved.quaternion[:, i] - low) / (high - low)
        up = (points[:, 1].max() - points[:, 1]) / np.ptp([y for each in q for y in each[:, 1]])
        np.testing.assert_allclose(up - up[0], heights - heights[0], rtol=0, atol=2e-3)
        assert np.all(np.diff(points[:, 0]) > 0)
    assert len(errors) == 1 + len(moved.drift)
    assert all(np.all(np.diff(points[:, 1]) <= 0) for points in errors)
    text = moved._repr_html_()
    assert "drift of H" in text
    assert f"{TIMES[-1]:.6g}" in text


def test_long_motions_and_ensembles_stay_small():
    system, times = pt.System(BODY), np.linspace(0, 50, 20_001)
    long = pt.propagate(system, START, times)._repr_html_()
    assert len(long) < 60_000
    flips = curve_points(long)[0]
    assert len(flips) == 300
    few = ensemble()._repr_html_()
    assert "member 0" in few
    assert len(curve_points(few)) == len(ensemble())
    assert len(curve_points(pair_motion()._repr_html_())) == 2 + len(pair_motion().drift)
    assert curve_points(motion()[:1]._repr_html_()) == []
