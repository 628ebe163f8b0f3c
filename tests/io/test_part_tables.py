"""Parts of finite elements inside model files: one source of parameters, and data files that do not fit it.

References: beams in closed form (Timoshenko & Young); the same model with the part reduced by hand.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import parts
from flexmb.errors import FlexmbError, ModelError

CANTILEVER = """
gravity = [0, 0, "= -g"]
[parameters]
g = 9.81
length = 1.0
height = 0.01
young = 210e9
[[body]]
kind = "Ground"
markers = { wall = [0, 0, 0] }
[[body]]
kind = "FloatingBody"
name = "beam"
[body.data]
interfaces = { root = "start", tip = "end" }
stations = { middle = "mid" }
modes = 4
loads = { air = { kind = "Forces", on = "mid", force = [0, 0, 1] } }
[[body.data.pieces]]
kind = "Line"
points = [[0, 0, 0], ["= length", 0, 0]]
section = { kind = "Section.rectangle", width = 0.02, height = "= height" }
material = { kind = "Material", young = "= young", poisson = 0.3, density = 7850 }
elements = 10
nodes = { mid = 0.5 }
[[joint]]
kind = "Fixed"
name = "clamp"
markers = ["ground.wall", "beam.root"]
[[sensor]]
kind = "Position"
name = "tip"
marker = "beam.tip"
[simulation]
t_end = 0.01
samples = 3
"""
TABLE = CANTILEVER[CANTILEVER.index("[body.data]") : CANTILEVER.index("[[joint]]")]


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "cantilever.toml"
    path.write_text(CANTILEVER)
    return path


@pytest.mark.parametrize(
    "given", [{}, {"length": 1.2}, {"height": 0.012}, {"young": 100e9}, {"length": 0.8, "young": 300e9}]
)
def test_parameters_reach_the_elements(file, given):
    """Tip under its own weight, -rho A g L^4 / (8 E I), whatever is set."""
    values = {"length": 1.0, "height": 0.01, "young": 210e9, **given}
    tip = fmb.statics(fmb.load_model(file, given))["tip"][-1, 2]
    weight, inertia = 7850.0 * 0.02 * values["height"] * 9.81, 0.02 * values["height"] ** 3 / 12.0
    assert tip == pytest.approx(-weight * values["length"] ** 4 / (8.0 * values["young"] * inertia), rel=3e-3)


def test_the_parameters_are_noted_and_runs_keep_the_body(file, tmp_path):
    model = fmb.load_model(file, {"length": 1.2})
    data = next(body.data for body in model.bodies if body.name == "beam")
    assert data.recipe["parameters"] == {"length": 1.2, "height": 0.01, "young": 210e9}
    saved = fmb.save_model(model, tmp_path / "out" / "cantilever.toml")
    again = fmb.load_model(saved)
    assert next(b.data for b in again.bodies if b.name == "beam").frequencies == pytest.approx(data.frequencies)


def test_a_data_file_of_other_parameters_is_refused(file, tmp_path):
    """The stiffness of a body in a file does not follow `--set`: that is an error now, and was silence."""
    model = fmb.load_model(file)
    saved = fmb.save_model(model, tmp_path / "out" / "cantilever.toml")
    with pytest.raises(ModelError, match=r"was made with young = 210000000000\.0, the model has 100000000000\.0"):
        fmb.load_model(saved, {"young": 100e9})
    assert fmb.load_model(saved, {"g": 1.6}), "what the body does not depend on may change"


def test_a_script_notes_its_parameters(file, tmp_path):
    """Data of a script carry what they were made with, if it says so."""
    data = next(b.data for b in fmb.load_model(file).bodies if b.name == "beam")
    data.made_with({"height": 0.01, "length": 1.0}).save(tmp_path / "beam.h5")
    path = tmp_path / "other.toml"
    path.write_text(CANTILEVER.replace(TABLE, 'data = "beam.h5"\n'))
    assert fmb.load_model(path)
    with pytest.raises(ModelError, match=r"made with height = 0\.01, the model has 0\.02"):
        fmb.load_model(path, {"height": 0.02})


def test_cases_and_assemblies_share_the_part(file, tmp_path):
    """A case changes the section of its base; two assemblies of one description are one part."""
    case = tmp_path / "thick.toml"
    case.write_text('base = "cantilever.toml"\n[parameters]\nheight = 0.02\n')
    one, two = (
        next(b.data for b in fmb.load_model(path).bodies if b.name == "beam").frequencies[0] for path in (file, case)
    )
    assert two / one == pytest.approx(2.0, rel=1e-2)  # of a beam twice as high
    pair = tmp_path / "pair.toml"
    pair.write_text(
        '[[assembly]]\nfile = "cantilever.toml"\nprefix = "a"\n'
        '[[assembly]]\nfile = "cantilever.toml"\nprefix = "b"\nat = [0, 1, 0]\n'
    )
    with parts.watching(parts.Count()) as count:
        model = fmb.load_model(pair)
    bodies = [b for b in model.bodies if b.name.endswith("beam")]
    assert count.reduced + count.reused == 1
    assert bodies[0].data is bodies[1].data


def test_a_mesh_beside_the_model_file(file, tmp_path):
    """Solids from a mesh, named relative to the model file, lengthened by a parameter."""
    from pathlib import Path

    mesh = Path(__file__).parents[2] / "meshes" / "bracket_hex8.msh"
    (tmp_path / "bracket.msh").write_bytes(mesh.read_bytes())
    groups = fmb.fem.read_mesh(mesh)
    x = groups.points[:, 0]
    table = f"""
[body.data]
interfaces = {{ root = {{ kind = "Averaging", where = "{sorted(groups.facet_sets)[0]}" }} }}
stations = {{ tip = [0.0, 0.0, 0.0], middle = [0.0, 0.0, 0.0] }}
modes = 0
compare = 0
[[body.data.pieces]]
kind = "MeshFile"
file = "bracket.msh"
material = "steel"
stretch = [{{ kind = "Stretch", along = [1, 0, 0], between = [{x.min()}, {x.max()}], by = "= length - 1" }}]
"""
    file.write_text(CANTILEVER.replace(TABLE, table))
    short, long = (
        next(b.data for b in fmb.load_model(file, {"length": 1.0 + by}).bodies if b.name == "beam")
        for by in (0.0, 0.05)
    )
    assert np.ptp(long.nodes[:, 0]) - np.ptp(short.nodes[:, 0]) == pytest.approx(0.05, rel=1e-12)
    assert long.mass / short.mass == pytest.approx(1.0 + 0.05 / np.ptp(x), rel=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('kind = "Line"', 'kind = "Lime"', "Did you mean 'Line'"),
        ("elements = 10", "element = 10", "Did you mean 'elements'"),
        ('height = "= height" }', "height = 0.0 }", "height = 0.0 m"),
        ("modes = 4", "mods = 4", "Did you mean 'modes'"),
        ('root = "start"', 'root = "strat"', "Did you mean 'start'"),
        ("nodes = { mid = 0.5 }", 'nodes = { mid = "= 2*length" }', "node 'mid'"),
        ("nodes = { mid = 0.5 }", "nodes = { half = 0.5 }", "the group 'mid' does not exist"),
        ("force = [0, 0, 1]", "force = [0, 1]", "three components"),
        ('kind = "Line"\n', "", "the field 'kind' is missing"),
        ("modes = 4", 'modes = 4\ndeck = "wing.bdf"', "both pieces and a deck"),
        ('length", 0, 0]]', 'lenght", 0, 0]]', "lenght"),
    ],
)
def test_bad_tables_name_the_place(file, old, new, message):
    assert old in CANTILEVER
    file.write_text(CANTILEVER.replace(old, new))
    with pytest.raises(FlexmbError, match=message) as told:
        fmb.load_model(file)
    assert "'beam', data" in told.value.part


def test_hostile_tables_end_with_a_message(file):
    """Elements without number, files that are none, names that no system has."""
    for old, new in (
        ("elements = 10", "size = 1e-12"),
        ("elements = 10", "elements = 100000000000"),
        ('kind = "Line"', 'kind = "MeshFile"\nfile = "/dev/zero"'),
        ("modes = 4", 'modes = 4\ndeck = "/dev/zero"'),
    ):
        file.write_text(CANTILEVER.replace(old, new))
        with pytest.raises(FlexmbError):
            fmb.load_model(file)
