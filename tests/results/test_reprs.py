"""What is printed of the objects a user handles: a line with what matters, no arrays."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.system import assemble

STEEL = fmb.MATERIALS["steel"]
TUBE = fem.Section.tube(diameter=0.02, wall=0.002)


@pytest.fixture(scope="module")
def things():
    """Return one object of every kind, by name."""
    mesh = fem.read_mesh("meshes/conrod.msh")
    fe = fem.frame(points=np.linspace(0, 1, 30)[:, None] * [1.0, 0, 0], section=TUBE, material=STEEL)
    data = reduction.reduce(fe, interfaces={"a": "start", "b": "end"}, modes=2)
    body = fmb.FloatingBody("beam", data=data)
    model = fmb.Model(
        bodies=[fmb.Ground(), body],
        joints=[fmb.Revolute("hinge", markers=("ground.origin", "beam.a"))],
        sensors=[fmb.Position("tip", marker="beam.b")],
    )
    solution = fmb.simulate(model, 0.01, samples=3)
    return {
        "mesh": mesh,
        "fe": fe,
        "data": data,
        "body": body,
        "model": model,
        "solution": solution,
        "instant": solution.final,
        "linear": fmb.linearize(model),
        "accelerations": fmb.accelerations(model),
        "system": assemble(model)[0],
        "report": fmb.check(model),
        "section": TUBE,
        "table": fmb.table(np.linspace(0, 1, 500), np.linspace(0, 3, 500)),
    }


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("mesh", ("Mesh('conrod': ", " nodes, ", " tetra10", " m, sets: bore_a, bore_b, conrod")),
        ("fe", ("FEModel('frame': 30 nodes, 180 freedoms, 29 line, sets: end, start)",)),
        ("data", ("ModalNeutralData('frame': ", " kg, 8 flexible coordinates, first ", "markers: a, b)")),
        ("body", ("FloatingBody(name='beam'", "ModalNeutralData('frame'")),
        ("model", ("Model('model': 2 bodies, 1 joints, 1 sensors)",)),
        ("solution", ("Solution(3 samples, t = 0 to 0.01 s; finished", "sensors: tip)")),
        ("instant", ("Instant(t = 0.01 s, 15 coordinates",)),
        ("linear", ("Linearization(9 freedoms: ", " Hz; ")),
        ("accelerations", ("[body] for ground, beam; reactions: hinge",)),
        ("system", ("14 velocities, 5 equations)",)),
        ("report", ("mobility 9",)),
        ("section", ("Section(tube 0.02 0.002 0: area 0.0001131 m2",)),
        ("table", ("Table(500 points, x 0 to 1, y 0 to 3, cubic)",)),
    ],
)
def test_a_line_with_what_matters(things, name, parts):
    text = repr(things[name])
    assert len(text) < 400
    for part in parts:
        assert part in text
