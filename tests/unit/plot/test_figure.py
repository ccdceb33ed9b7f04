"""Resolution and text of saved figures."""

import io

import pytest

from poinsot.plot.figure import DOTS_PER_INCH, TextFigure


@pytest.mark.parametrize(
    ("name", "options", "dpi"),
    [
        ("x.pdf", {}, DOTS_PER_INCH),
        ("X.SVG", {}, DOTS_PER_INCH),
        ("x.png", {}, None),
        ("x.pdf", {"dpi": 70}, 70),
        (io.BytesIO(), {"format": "svg"}, DOTS_PER_INCH),
        (io.BytesIO(), {"format": "png"}, None),
    ],
)
def test_resolution(monkeypatch, name, options, dpi):
    given = {}
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda *_, **options: given.update(options))
    TextFigure().savefig(name, **options)
    assert given.get("dpi") == dpi


def test_text_of_a_vector_file_is_text():
    figure, file = TextFigure(), io.StringIO()
    figure.text(0.5, 0.5, "nutation")
    figure.savefig(file, format="svg")
    assert ">nutation<" in file.getvalue()
