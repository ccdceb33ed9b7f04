"""Nodes of a graph as formulas, and tables of systems from plain data."""

import pytest

from poinsot import functions
from poinsot.display.formulas import (
    MAX_SYMBOLS,
    ForceSummary,
    StatedFormula,
    SystemSummary,
    TracedFormula,
    equations,
    letters_of,
    system_html,
    system_latex,
)
from poinsot.display.notation import LATEX, MATHML
from poinsot.taylor.graph import Graph, GraphScalar

GRAPH = Graph()
A, B, C = (GRAPH.symbol((name, index)) for name, index in (("a", ""), ("b", "1"), ("rate", "")))


def latex(*components):
    return equations(TracedFormula("U", components), LATEX)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (A + B, "a + b_{1}"),
        (A - B, "a - b_{1}"),
        (-A - B, "- a - b_{1}"),
        (2.5 * A * A, r"2.5\,{a}^{2}"),
        (-A / 2, r"- 0.5\,a"),
        (A / (B * B), r"\frac{a}{{b_{1}}^{2}}"),
        (1 / A, r"\frac{1}{a}"),
        (A * (B + C), r"a\,\left(\mathrm{rate} + b_{1}\right)"),
        (functions.sqrt(A), r"\sqrt{a}"),
        (functions.sin(A + 1), r"\operatorname{sin}\left(1 + a\right)"),
        (2.5e-7 * A, r"2.5 \times 10^{-7}\,a"),
        (3, "3"),
        (1 / 3, "0.333333"),
    ],
)
def test_a_scalar_is_typeset(value, text):
    assert latex(value) == [f"U = {text}"]


def test_a_vector_is_in_brackets():
    assert latex(A, 0.0, -B) == [r"U = \left(a, 0, - b_{1}\right)"]


def test_a_condition_is_typeset():
    (text,) = equations(TracedFormula("U", [functions.where(A < 1.0, B, 2.0)]), MATHML)
    assert "<mi>where</mi>" in text
    assert "<mo>&lt;</mo>" in text


def test_a_long_formula_has_no_equations():
    symbols = [GRAPH.symbol((f"x{i}", "")) for i in range(MAX_SYMBOLS + 1)]
    assert latex(sum(symbols[1:], symbols[0])) == []
    assert len(latex(sum(symbols[2:], symbols[1]))) == 1


def test_a_deeply_nested_formula_has_no_equations():
    total: GraphScalar = A
    for _ in range(5000):
        total = total + B
    assert latex(total) == []


@pytest.mark.parametrize("value", [GRAPH.variable(1.0), GRAPH.input(0) * A, "text", None, [1.0], 2j])
def test_other_than_named_real_numbers_have_no_equations(value):
    assert latex(value) == []


def test_no_formula_has_no_equations():
    assert equations(None, LATEX) == []


def test_letters_of_the_second_orbit_have_a_prime():
    assert equations(StatedFormula("U = -mu/r"), LATEX) == [r"U = \frac{-\mu}{r}"]
    assert equations(StatedFormula("U = -mu/r", 1), LATEX) == [r"U = \frac{-\mu}{r'}"]


def test_letters_are_explained_where_they_occur():
    shown = equations(StatedFormula("N = cross(u, omega)"), MATHML)
    assert list(letters_of(shown, two_bodies=False)) == ["N", "u", "omega"]
    assert letters_of(shown, two_bodies=False)["u"] == "unit vector from the attractor, body axes"
    assert letters_of(shown, two_bodies=True)["u"] == "unit vector from the primary to the secondary"


SYSTEM = SystemSummary(
    motion="rate(g) = N",
    body="Body(<b>)",
    forces=[
        ForceSummary("Stated", "not shown", "Stated(k=1.0000000001)", StatedFormula("N = k*u")),
        ForceSummary("Looked_up", "A torque & a table.", "Looked_up()", None),
    ],
    conserved=["H: energy"],
    two_bodies=False,
)


def test_the_table_of_a_system():
    text = system_html(SYSTEM)
    rows = [text.index(f">{name}</th>") for name in ("motion", "body", "Stated", "Looked_up", "conserved", "letters")]
    assert rows == sorted(rows)
    assert "Body(&lt;b&gt;)" in text
    assert "Stated(k=1)" in text
    assert "not shown" not in text
    assert "A torque &amp; a table." in text
    assert "H: energy" in text
    assert "torque, body axes" in text


def test_a_system_without_integrals_and_equations():
    text = system_html(SystemSummary("", "TwoBodies()", [], [], True))
    assert ">motion<" not in text
    assert ">letters<" not in text
    assert "neither energy nor a momentum" in text


def test_the_equations_of_a_system_in_latex():
    assert system_latex(SYSTEM) == (r"$$\begin{gathered}\dot{g} = N \\ N = k\,u\end{gathered}$$")
