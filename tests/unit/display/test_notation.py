"""Formulas that are stated as Python, in LaTeX and MathML."""

from xml.etree import ElementTree as ET

import pytest

from poinsot.display.notation import LATEX, MATHML, split_name, typeset_stated


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("mu", ("mu", "")),
        ("orbit.mu", ("mu", "")),
        ("center_of_mass[0]", ("center_of_mass", "1")),
        ("tensor[0][2]", ("tensor", "13")),
        ("parts[1].axis[2]", ("axis", "3")),
        ("C20", ("C", "20")),
        ("J2", ("J", "2")),
        ("mass2", ("mass2", "")),
    ],
)
def test_a_name_has_a_base_and_an_index(name, parts):
    assert split_name(name) == parts


@pytest.mark.parametrize(
    ("name", "latex", "mathml"),
    [
        ("x", "x", "<mi>x</mi>"),
        ("x''", "x''", "<mi>x′′</mi>"),
        ("mu", r"\mu", "<mi>μ</mi>"),
        ("omega'", r"\omega'", "<mi>ω′</mi>"),
        ("spring_rate", r"\mathrm{spring~rate}", "<mi>spring rate</mi>"),
        ("rate'", r"\mathrm{rate}'", "<mi>rate′</mi>"),
        ("<b>", r"\mathrm{<b>}", "<mi>&lt;b&gt;</mi>"),
    ],
)
def test_letters(name, latex, mathml):
    assert LATEX.letter(name) == latex
    assert MATHML.letter(name) == mathml


@pytest.mark.parametrize(
    ("formula", "latex"),
    [
        ("N = -(k*x)", [r"N = -k\,x"]),
        ("a = b*(c + d)", [r"a = b\,\left(c + d\right)"]),
        ("a = b - (c - d)", [r"a = b - \left(c - d\right)"]),
        ("a = b + (c - d)", ["a = b + c - d"]),
        ("a = (b + c)/d**2", [r"a = \frac{b + c}{{d}^{2}}"]),
        ("a = (b*c)**2", [r"a = {\left(b\,c\right)}^{2}"]),
        ("N = cross(x, v); U = dot(a + b, c)", [r"N = x \times v", r"U = \left(a + b\right) \cdot c"]),
        ("N = K*cross(x, v)", [r"N = K\,\left(x \times v\right)"]),
        ("rate(g) = norm(x)*sin(t)", [r"\dot{g} = \left|x\right|\,\operatorname{sin}\left(t\right)"]),
        ("N = sum(m[i]*x[i], i)", [r"N = \sum_{i} m_{i}\,x_{i}"]),
        ("U = mu*sum(C[n, m], n, 2, degree)", [r"U = \mu\,\sum_{n = 2}^{\mathrm{degree}} C_{nm}"]),
        ("a = C20 + min(a, b)", [r"a = C_{20} + \operatorname{min}\left(a, b\right)"]),
        ("a = -(b + c)", [r"a = -\left(b + c\right)"]),
        ("a = -b*c", [r"a = \left(-b\right)\,c"]),
    ],
)
def test_equations_in_latex(formula, latex):
    assert typeset_stated(formula, LATEX) == latex


def test_chosen_letters_have_primes():
    assert typeset_stated("U = mu/r", LATEX, {"r", "u"}, 2) == [r"U = \frac{\mu}{r''}"]


def test_mathml_is_well_formed_and_has_the_elements_of_each_operation():
    (one,) = typeset_stated("rate(g) = sum(a[i]**2/norm(b), i, 1, n) - cross(c, d)*dot(e, f)", MATHML)
    tags = [element.tag for element in ET.fromstring(f"<math>{one}</math>").iter()]
    for tag, count in {"mover": 1, "munderover": 1, "msub": 1, "msup": 1, "mfrac": 1}.items():
        assert tags.count(tag) == count


@pytest.mark.parametrize(
    "formula", ["N = 2 +", "N = x if y else z", "N = cross(x)", "N = rate()", "N = a % b", "N = +a"]
)
def test_another_syntax_is_refused(formula):
    with pytest.raises(ValueError, match="formula of a class must be equations of names, numbers") as error:
        typeset_stated(formula, LATEX)
    assert repr(formula) in str(error.value)
