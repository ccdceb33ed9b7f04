"""The pictures of the gallery: a drawing for each example, and a square thumbnail of one panel."""

import itertools
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image
from tools.site import drawing, gallery

mpl.use("Agg")

BUILT = Path(__file__).parents[2] / "docs" / "generated" / "gallery"
NAMES = sorted(gallery.QUESTIONS)
MAPS = {"dimorphos_map", "megno_map"}
"""Pictures whose cells fill the panel."""


@pytest.fixture(autouse=True)
def no_figures():
    yield
    plt.close("all")


def test_every_scenario_without_a_program_has_a_drawing():
    scenarios, programs = ({path.stem for path in gallery.EXAMPLES.glob(f"*.{kind}")} for kind in ("toml", "py"))
    assert set(drawing.DRAWINGS) == scenarios - programs
    assert set(drawing.PANELS) <= programs


def test_every_question_is_asked_once():
    assert len(set(gallery.QUESTIONS.values())) == len(NAMES)


def wide_figure():
    """Two rows of two panels with long labels, a common horizontal axis, a legend, a title and very many ticks."""
    figure, panels = plt.subplots(2, 2, figsize=(15, 6), layout="constrained", sharex=True)
    for panel in panels.flat:
        for k in range(5):
            panel.plot([0, 1], [k, 1], label=f"a curve with a long name, number {k}")
        panel.set_ylabel("a quantity with a name that is too long for four inches [kg m² s⁻¹]")
        panel.legend()
    for panel in panels[1]:
        panel.set_xlabel("time [h]")
    panels[0, 1].set_yticks(np.linspace(0, 5, 120), [f"row {i}" for i in range(120)])
    figure.suptitle("All panels")
    return figure


@pytest.mark.parametrize("index", range(4))
def test_a_thumbnail_is_a_square_with_one_panel_and_all_its_words(index, tmp_path):
    figure = wide_figure()
    panel = drawing.thumbnail(figure, index)
    assert figure.axes == [panel]
    assert panel.get_xlabel() == "time [h]"
    figure.savefig(tmp_path / "thumbnail.png", dpi=figure.dpi)
    with Image.open(tmp_path / "thumbnail.png") as picture:
        assert picture.width == picture.height == round(drawing.SIDE * figure.dpi)
        side = picture.width
    for words in (panel.xaxis.label, panel.yaxis.label, panel.title, panel.get_legend()):
        low, high = words.get_window_extent().get_points()
        assert np.all(low >= -1), words
        assert np.all(high <= side + 1), words
    if panel.yaxis.get_tick_params()["labelleft"]:
        boxes = [tick.get_window_extent() for tick in panel.get_yticklabels() if tick.get_text()]
        edges = sorted((box.y0, box.y1) for box in boxes)
        assert all(after[0] >= before[1] for before, after in itertools.pairwise(edges))


@pytest.mark.docs
@pytest.mark.parametrize("name", NAMES)
def test_thumbnails_of_the_site_are_of_equal_size_and_not_empty(name):
    with Image.open(BUILT / name / "thumbnail.jpg") as picture:
        assert picture.width == picture.height == drawing.SIDE * drawing.DOTS
        shades = np.asarray(picture.convert("L"))
    assert np.mean(shades < 128) > 0.005, "the picture must contain more than white"
    assert name in MAPS or np.mean(shades > 240) > 0.4, "no area may fill the picture"


@pytest.mark.docs
def test_no_two_thumbnails_of_the_site_are_alike():
    small = {}
    for name in NAMES:
        with Image.open(BUILT / name / "thumbnail.jpg") as picture:
            small[name] = np.asarray(picture.convert("L").resize((60, 60)), dtype=float)
    for one, other in itertools.combinations(NAMES, 2):
        assert np.mean(np.abs(small[one] - small[other])) > 2, (one, other)
