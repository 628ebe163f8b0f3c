"""Loads of tables and of flow solvers in the description of a part in a model file; switched by a parameter.

Reference: the deflection of a cantilever under a uniform load, q L^4 / (8 E I).
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import FlexmbError

SPAN, CHORD, PRESSURE = 3.0, 0.5, 400.0
EI = 70e9 * 1e-6
MODEL = """
name = "wing"
[parameters]
span = 3.0
from_file = 0
[[body]]
kind = "Ground"
[[body]]
kind = "FloatingBody"
name = "wing"
[body.data]
interfaces = { root = "start", tip = "end" }
modes = 4
residual_vectors = "all"
[body.data.loads]
flow = { kind = "SurfaceFile", file = "flow.csv", factor = 2.0 }
lift = { kind = "LineTable", points = [[0, 0, 0], [0, "= span", 0]], force = [0, 0, [200.0, 200.0]] }
[body.data.loads.air]
kind = "PressureTable"
corners = [[-0.2, 0, 0], [0.3, 0, 0], [0.3, "= span", 0], [-0.2, "= span", 0]]
span = [0]
chord = [0]
pressure = [[400.0]]
[[body.data.pieces]]
kind = "Line"
points = [[0, 0, 0], [0, "= span", 0]]
elements = 12
shear = false
material = { kind = "Material", young = 70e9, poisson = 0.3, density = 2700 }
section = { kind = "Section.values", area = 4e-3, inertia_y = 1e-6, inertia_z = 1e-4, torsion = 2e-6 }
[[joint]]
kind = "Fixed"
name = "wall"
markers = ["ground.origin", "wing.root"]
[[force]]
if = "= from_file"
kind = "Pressure"
name = "flow"
load = "wing.flow"
amount = 1.0
[[force]]
unless = "= from_file"
kind = "Pressure"
name = "air"
load = "wing.air"
amount = 1.0
[[sensor]]
kind = "Position"
name = "tip"
marker = "wing.tip"
[[sensor]]
kind = "Reaction"
name = "wall"
joint = "wall"
"""


@pytest.fixture
def model(tmp_path, monkeypatch):
    """The model file with a table of 30 points that carry half of the pressure."""
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "bodies"))
    y = (np.arange(30) + 0.5) * SPAN / 30
    rows = np.column_stack([0 * y + 0.05, y, 0 * y, 0 * y + PRESSURE / 2, 0 * y, 0 * y, 0 * y - CHORD * SPAN / 30])
    np.savetxt(tmp_path / "flow.csv", rows, delimiter=",", header="x,y,z,p,ax,ay,az", comments="", fmt="%.17g")
    (tmp_path / "wing.toml").write_text(MODEL)
    return tmp_path / "wing.toml"


@pytest.mark.parametrize("from_file", [0, 1])
def test_switched_by_a_parameter(model, from_file):
    """The same lift from a table over span and chord and a file: q L^4 / (8 E I), and the moment about the beam."""
    solution = fmb.statics(fmb.load_model(model, {"from_file": from_file}))
    lift = PRESSURE * CHORD
    assert solution["tip"][-1, 2] == pytest.approx(lift * SPAN**4 / (8 * EI), rel=2e-3)
    force = -lift * SPAN
    expected = [0, 0, force, force * SPAN / 2, -0.05 * force, 0]
    np.testing.assert_allclose(solution["wall"][-1], expected, atol=2e-3 * abs(force * SPAN))


def test_what_the_file_holds_decides(model):
    """Another pressure in the file is another body; the span reaches the load."""
    data = fmb.load_model(model).body("wing").data
    span = fmb.load_model(model, {"span": 3.5}).body("wing").data
    assert span.load_names == data.load_names == ("flow", "lift", "air")
    text = (model.parent / "flow.csv").read_text().replace("200", "210")
    (model.parent / "flow.csv").write_text(text)
    again = fmb.load_model(model).body("wing").data
    names = list(data.load_names)
    forces = {
        name: [np.abs(d.load_shapes[names.index(name)]).max() for d in (data, again)]
        for name in ("air", "flow", "lift")
    }
    assert forces["air"][0] == pytest.approx(forces["air"][1], rel=1e-12)
    assert forces["flow"][1] == pytest.approx(1.05 * forces["flow"][0], rel=1e-6)


def test_a_file_that_is_not_there(model):
    model.write_text(model.read_text().replace("flow.csv", "flaw.csv"))
    with pytest.raises(FlexmbError, match="flaw"):
        fmb.load_model(model)


def test_an_optimiser_reaches_the_elements(model):
    """The span at which the tip gives way by 20 mm, by Brent's method over the model file: (8 E I w/q)^(1/4)."""
    from scipy.optimize import brentq

    def gap(span):
        return fmb.statics(fmb.load_model(model, {"span": span}))["tip"][-1, 2] - 0.020

    assert brentq(gap, 2.0, 4.0, xtol=1e-4) == pytest.approx((8 * EI * 0.020 / (PRESSURE * CHORD)) ** 0.25, rel=2e-3)
