"""Script that reduces the triangles of a CAD mesh and reports how far the surface has moved."""

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

from simcore.world.field import FieldGeometry
from simcore.world.obj import ObjGroup, format_obj, read_obj

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "simplify_field.py"
spec = importlib.util.spec_from_file_location("simplify_field", SCRIPT)
script = importlib.util.module_from_spec(spec)
spec.loader.exec_module(script)


def group(name, mesh, shift=(0.0, 0.0, 0.0)):
    return ObjGroup(name, np.asarray(mesh.vertices) + shift, tuple(tuple(f) for f in np.asarray(mesh.faces).tolist()))


@pytest.fixture
def dense(tmp_path):
    """Return a file with a ball of 5120 triangles, a finely divided box and a plain box."""
    ball, box = trimesh.creation.icosphere(subdivisions=4), trimesh.creation.box()
    fine = box.copy().subdivide().subdivide().subdivide()
    path = tmp_path / "dense.obj"
    path.write_text(format_obj([group("ball", ball), group("fine", fine, (5, 0, 0)), group("box", box, (9, 0, 0))]))
    return path


def run(dense, tmp_path, *args):
    out = tmp_path / "out.obj"
    return script.main([str(dense), str(out), *args]), out


def test_the_budget_is_met_while_groups_keep_their_names_and_the_box_is_unchanged(dense, tmp_path, capsys):
    pytest.importorskip("fast_simplification")
    code, out = run(dense, tmp_path, "--triangles", "600")
    assert code == 0
    groups = {g.name: g for g in read_obj(out)}
    assert list(groups) == ["ball", "fine", "box"]
    assert sum(len(g.faces) for g in groups.values()) <= 600
    assert len(groups["box"].faces) == 12
    FieldGeometry.load(out)
    text = capsys.readouterr().out
    assert re.search(r"triangles: 5900 -> \d+ in 3 groups", text)
    moved = [float(x) for x in re.search(r"moved by ([\d.]+) mm at most, ([\d.]+) mm on average", text).groups()]
    # A chord of a unit ball with edges of about 4 sqrt(pi / 600 / sqrt(3)) lies 1/2 (edge^2 / 3) = 8 mm below it.
    assert 2.0 < moved[0] < 60.0 and moved[1] < moved[0] / 2
    assert "'ball'" in text


def test_a_mesh_within_the_budget_is_written_unchanged(dense, tmp_path, capsys):
    code, _ = run(dense, tmp_path, "--triangles", "10000")
    assert code == 0
    assert "moved by 0.00 mm at most" in capsys.readouterr().out


def test_the_scale_converts_millimeters_to_meters(dense, tmp_path):
    _, out = run(dense, tmp_path, "--triangles", "10000", "--scale", "0.001")
    assert max(np.abs(g.vertices).max() for g in read_obj(out)) == pytest.approx(0.0095)


def test_the_deviation_of_a_shifted_box_is_the_shift():
    """A box is raised by 3 mm: its side faces stay in their planes, its top and bottom move by exactly 3 mm."""
    box = trimesh.creation.box()
    distances = script.deviation(group("a", box), group("b", box, (0, 0, 0.003)), 500)
    assert distances.max() == pytest.approx(0.003)
    assert distances.min() == pytest.approx(0.0, abs=1e-12)


def test_the_deviation_agrees_with_a_search_of_all_pairs():
    """The search by size classes finds the same distances as a search of every triangle."""
    rng = np.random.default_rng(3)
    triangles = rng.normal(size=(80, 3, 3)) * rng.choice([0.01, 0.1, 3.0], size=(80, 1, 1)) + rng.normal(
        size=(80, 1, 3)
    )
    points = rng.normal(size=(50, 3))
    each = [trimesh.triangles.closest_point(triangles, np.repeat(p[None], 80, axis=0)) - p for p in points]
    assert script._distances(points, triangles) == pytest.approx([np.linalg.norm(e, axis=1).min() for e in each])


def test_the_error_for_a_missing_package_gives_the_install_command(dense, tmp_path, capsys, monkeypatch):
    def gone(name):
        raise ModuleNotFoundError(f"No module named {name!r}")

    monkeypatch.setattr(script.importlib, "import_module", gone)
    code, out = run(dense, tmp_path, "--triangles", "600")
    assert code == 1 and not out.exists()
    assert "pip install fast-simplification" in capsys.readouterr().err


def test_a_missing_input_is_reported_without_a_traceback(tmp_path, capsys):
    code, _ = run(tmp_path / "nowhere.obj", tmp_path)
    assert code == 1
    assert "nowhere.obj" in capsys.readouterr().err


def test_an_unwritable_output_is_reported_without_a_traceback(dense, tmp_path, capsys):
    assert script.main([str(dense), str(tmp_path / "no" / "out.obj"), "--triangles", "10000"]) == 1
    assert "cannot write" in capsys.readouterr().err


@pytest.mark.parametrize("args", [["--triangles", "3"], ["--scale", "0"], ["--scale", "nan"]])
def test_invalid_arguments_of_the_script_are_refused(dense, tmp_path, args, capsys):
    with pytest.raises(SystemExit):
        run(dense, tmp_path, *args)
    assert args[0] in capsys.readouterr().err
