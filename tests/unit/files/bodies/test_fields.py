"""Tables of coefficients in both formats, written here from one field; and what is refused."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import poinsot as pt
from poinsot.shapes.shape import MAX_DEGREE

FIELD = pt.shapes.Mesh(
    [(0.0, 0, 0), (1.5, 0.2, 0), (0.1, 1.2, -0.1), (0.3, 0.4, 1.1)],
    [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)],
    mass=2.0,
).field(4)


def rows(normalized=True, first=0):
    C, S = FIELD.normalized if normalized else (FIELD.C, FIELD.S)
    return [(n, m, C[n, m], S[n, m]) for n in range(first, 5) for m in range(n + 1)]


def shadr(lines=None, radius=0.25, degree=4, order=4, flag=1, turn=0.0):
    header = f" {radius:.16E}, 4.9E+03, 1.0E-04, {degree:5d}, {order:5d}, {flag:5d}, {turn:.10E}, {0:.10E}\r\n"
    body = [f"{n:5d},{m:5d}, {c:.17E}, {s:.17E}, {0:.10E}, {0:.10E}\r\n" for n, m, c, s in lines or rows(first=1)]
    return header + "".join(body)


def icgem(lines=None, keys="", norm="norm fully_normalized\n", opening="a comment: radius 7\nbegin_of_head ==\n"):
    head = (
        f"{opening}product_type gravity_field\nmodelname test\nearth_gravity_constant 1.0\n"
        f"radius {0.25:.16E}\nmax_degree 4\n{norm}{keys}end_of_head ====\n"
    )
    body = [f"gfc {n} {m} {c:.17E} {s:.17E} 0.0 0.0\n".replace("E", "D") for n, m, c, s in lines or rows()]
    return head + "".join(body)


def read(folder, text, *args, **kwargs):
    path = folder / "table"
    path.write_text(text, newline="")
    return pt.files.read_field(path, *args, **({"mass": 3.0} | kwargs))


@pytest.mark.parametrize(
    "text",
    [
        shadr(),
        shadr(rows(False), flag=0),
        shadr().replace(",", " "),
        icgem(),
        icgem(rows(False), norm="norm unnormalized\n"),
        icgem(norm=""),
        icgem(opening=""),
        icgem(rows(first=2)),
    ],
)
def test_both_formats_bring_the_field_back(text, tmp_path):
    field = read(tmp_path, text)
    assert (field.degree, field.mass, field.radius, field.extent) == (4, 3.0, 0.25, 0.25)
    np.testing.assert_allclose(field.C, FIELD.C, rtol=1e-15, atol=0)
    np.testing.assert_allclose(field.S, FIELD.S, rtol=1e-15, atol=0)


def test_degree_and_unit(tmp_path):
    field = read(tmp_path, shadr(), 3, unit=1000.0)
    assert (field.degree, field.radius) == (3, 250.0)
    np.testing.assert_allclose(field.C, FIELD.C[:4, :4], rtol=1e-15, atol=0)
    with pytest.raises(ValueError, match=r"degree must be from 2 to 4, got 5\. The table has 4"):
        read(tmp_path, shadr(), 5)
    with pytest.raises(TypeError, match=r"degree must be a whole number of at most 63 bits, got float 3\.0\."):
        read(tmp_path, shadr(), 3.0)
    with pytest.raises(ValueError, match=f"degree must be from 2 to {MAX_DEGREE}, got 90"):
        read(tmp_path, shadr(degree=90))
    assert read(tmp_path, shadr([*rows(), (90, 3, 1e-9, 1e-9)], degree=90), 4).degree == 4
    with pytest.raises(ValueError, match="unit must be positive"):
        read(tmp_path, shadr(), unit=-1)
    with pytest.raises(ValueError, match="mass must be positive"):
        read(tmp_path, shadr(), mass=0)


def test_the_extent_is_in_the_unit_of_the_user_and_by_default_the_radius_of_the_table(tmp_path):
    for table in (shadr(), icgem()):
        assert read(tmp_path, table, unit=1000.0).extent == 250.0
        assert read(tmp_path, table, unit=1000.0, extent=310.0).extent == 310.0
        assert read(tmp_path, table, extent=0).extent == 0
    with pytest.raises(ValueError, match=r"extent must not be negative, got -1\.0"):
        read(tmp_path, shadr(), extent=-1.0)


def test_a_run_tells_when_the_attractor_was_within_the_radius_of_the_table(tmp_path):
    rest = pt.orbits.FixedPosition(1.0, position=(0.2, 0, 0))
    second = read(tmp_path, shadr(), 2)
    body = pt.Body.from_stokes(
        **{f"{name}2{m}": getattr(second, name)[2, m] for name in "CS" for m in range(3) if (name, m) != ("S", 0)},
        polar_moment_factor=4.0,
        mass=3.0,
        radius=0.25,
    )
    start = body.state((1, 0, 0, 0), omega_body=(0, 0, 0))
    with pytest.warns(UserWarning, match="0.05 below the sphere that holds the body"):
        force = pt.forces.HarmonicGravity(rest, second)
    assert pt.System(body, force).validity(start)["inside_sphere"]


def test_orders_beyond_those_of_the_table_are_zero(tmp_path):
    field = read(tmp_path, shadr([row for row in rows() if row[1] <= 1], order=1))
    assert not field.C[:, 2:].any()
    np.testing.assert_allclose(field.C[:, :2], FIELD.C[:, :2], rtol=1e-15, atol=0)


def changed(n, m, **new):
    index = {"C": 2, "S": 3}
    out = [list(row) for row in rows()]
    for row in out:
        if row[:2] == [n, m]:
            for name, value in new.items():
                row[index[name]] = value
    return out


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "the header must have radius, GM, its error, degree, order and normalization, got 0 fields"),
        ("1.0, 2.0, 0, 4, 4\n", "got 5 fields"),
        (shadr(flag=2), "the normalization must be 0 .none. or 1 .full., got 2"),
        (shadr(turn=1.0), "the reference longitude and latitude must be 0"),
        (shadr(radius=-1.0), "radius must be positive"),
        (shadr(changed(2, 0, S=1e-9)), "S must be zero in order 0, but S_20 is not"),
        (shadr(changed(0, 0, C=4.9e3)), "C_00 must be 1, or 0 where it is left out, got 4900"),
        (shadr(changed(1, 1, C=1e-5)), "C and S must be zero in degree 1, but they are not"),
        (shadr(changed(3, 1, C=float("nan"))), "a number must be finite and below 1e100, got 'NAN' in line 9"),
        (shadr(changed(3, 1, C=float("inf"))), "a number must be finite and below 1e100, got 'INF' in line 9"),
        (shadr(rows()[:-1]), "every coefficient must be given, got none for n = 4, m = 4"),
        (shadr([*rows(), rows()[-1]]), "a coefficient must come once, got n = 4, m = 4 again in line 17"),
        (shadr([*rows(), (5, 0, 0.0, 0.0)]), "n and m must have 0 <= m <= n <= 4, got 5, 0 in line 17"),
        (shadr([*rows(), (3, 4, 0.0, 0.0)]), "n and m must have 0 <= m <= n <= 4, got 3, 4 in line 17"),
        (shadr() + "6, 0\n", "a line must have n, m, C and S, got 2 fields in line 16"),
        (shadr() + "6.5, 0, 0, 0\n", "degrees and orders must be whole numbers, got '6.5' in line 16"),
        (
            icgem(keys="radius 0.5\n"),
            "the header must not repeat radius, got '0.5' after '2.5000000000000000E-01'. Remove one of them.",
        ),
        (
            icgem().replace("max_degree", "max_degre"),
            "the header must have a key of the format, got 'max_degre'. Did you mean 'max_degree'?",
        ),
        (icgem().replace("radius 2", "radios 2"), "the header must have radius, got none"),
        (
            icgem().replace("max_degree 4", "max_degree four"),
            "must be finite and below 1e100, got 'four' in the header",
        ),
        (icgem(norm="norm Schmidt\n"), "norm must be fully_normalized or unnormalized, got 'Schmidt'"),
        (icgem().replace("gfc 2 0", "gfct 2 0"), "the field must be static, lines of gfc, got 'gfct' in line 13"),
    ],
)
def test_tables_that_contradict_themselves_end_in_one_sentence(text, sentence, tmp_path):
    with pytest.raises(ValueError, match=sentence) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith(str(tmp_path / "table"))


def test_a_table_is_text_in_a_file(tmp_path):
    with pytest.raises(FileNotFoundError):
        pt.files.read_field(tmp_path / "none", mass=1.0)
    (tmp_path / "bytes").write_bytes(b"\xff\xfe\0")
    with pytest.raises(ValueError, match="must be text in UTF-8"):
        pt.files.read_field(tmp_path / "bytes", mass=1.0)


@settings(max_examples=150, deadline=10_000, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    text=st.sampled_from([shadr(), icgem()]),
    edits=st.lists(
        st.tuples(st.floats(0, 1), st.integers(0, 30), st.text("0123456789.,eEdD+-\n _gfcn", max_size=8)),
        min_size=1,
        max_size=4,
    ),
)
def test_any_text_ends_in_a_field_or_in_one_sentence(text, edits, tmp_path):
    for place, dropped, added in edits:
        at = int(place * len(text))
        text = text[:at] + added + text[at + dropped :]
    try:
        assert np.all(np.isfinite(read(tmp_path, text).C))
        sentence = ""
    except ValueError as error:
        sentence = str(error)
    assert "\n" not in sentence
