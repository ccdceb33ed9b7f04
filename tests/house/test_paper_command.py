"""The main job: `poinsot paper` writes what it says."""

import numpy as np
import pytest
import xarray
from typer.testing import CliRunner

from poinsot.cli import app
from poinsot.validation import paper


def test_paper_command_writes_figures_files_and_table(tmp_path, monkeypatch):
    one_each = [problem for problem in paper.PROBLEMS if problem.name in ("fig2-heavy-top", "fig3-kepler")]
    monkeypatch.setattr(paper, "PROBLEMS", one_each)
    result = CliRunner().invoke(app, ["paper", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert "5600 km from the centre, is 778.137 km below the surface" in " ".join(result.output.split())
    for name in ("fig2-heavy-top", "fig3-kepler"):
        for suffix in (".png", ".pdf", ".nc"):
            assert (tmp_path / f"{name}{suffix}").stat().st_size > 5000
        assert (tmp_path / "table.md").read_text().count(f"| {name} |") == 3


def test_paper_command_replaces_nothing_without_a_message(tmp_path, monkeypatch):
    (tmp_path / "fig3-kepler.pdf").write_text("mine")
    result = CliRunner().invoke(app, ["paper", "--out", str(tmp_path)], env={"COLUMNS": "400"})
    assert result.exit_code == 2
    assert "fig3-kepler.pdf already exists; use --overwrite." in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["fig3-kepler.pdf"]
    monkeypatch.setattr(paper, "PROBLEMS", paper.PROBLEMS[-1:])
    assert CliRunner().invoke(app, ["paper", "--out", str(tmp_path), "--overwrite"]).exit_code == 0
    assert (tmp_path / "fig3-kepler.pdf").exists()


def test_readings_of_the_paper():
    names = [problem.name for problem in paper.PROBLEMS]
    assert len(names) == len(set(names)) == 8
    # Same attitude, opposite momentum: what the paper calls equivalent is not (erratum E9).
    pair, euler = paper.PRINTED_PAIR, paper.EULER_SET
    np.testing.assert_allclose(pair.attitude.as_matrix(), euler.attitude.as_matrix(), rtol=0, atol=1e-15)
    np.testing.assert_allclose(pair.angular_momentum_body, -euler.angular_momentum_body, rtol=0, atol=1e-15)


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical", "euler_angles"])
def test_table_row_of_a_problem(formulation):
    problem = next(problem for problem in paper.PROBLEMS if problem.name == "fig2-heavy-top")
    _, rows = paper.solve(problem)
    row = next(row for row in rows if row.formulation == formulation)
    assert float(row.attitude_error) < 1e-12
    assert float(row.norm_error) < 1e-14
    assert row.drift.startswith("H ")


def test_saved_file_reads_back(tmp_path):
    problem = next(problem for problem in paper.PROBLEMS if problem.name == "fig3-kepler")
    motion, _ = paper.solve(problem)
    paper.write(motion, problem, tmp_path)
    with xarray.open_dataset(tmp_path / "fig3-kepler.nc", decode_times=False) as data:
        assert data.quaternion.dims == ("time", "parameter")
        np.testing.assert_array_equal(data.quaternion, motion.quaternion)
        assert data.time.units == "s"
        assert data.angular_momentum_body.units == "kg m2 s-1"
        assert data.attrs["formulation"] == "lie_poisson"
        assert data.attrs["steps"] == motion.run.steps
        assert data.attrs["integrals"].startswith("none")
