"""Cables and beams from meshes of lines: frames with corners and branches, rings, and what is refused."""

import itertools

import numpy as np
import pytest
from tolerances import SOLVER

import flexmb as fmb
from flexmb import fem
from flexmb.errors import ModelError

STEEL = fmb.Material(young=2e11, poisson=0.0, density=8000.0)
ROD = fem.Section.solid_circle(0.02)
EI = STEEL.young * ROD.inertia_y


def mesh(points, lines, **sets):
    return fem.Mesh(
        points=np.array(points, float),
        cells=(("line", np.array(lines)),),
        node_sets={name: np.array([node]) for name, node in sets.items()},
    )


def polyline(*corners, parts=4, **sets):
    """A mesh of straight sides, each in so many lines; sets name corners."""
    points = [np.array(corners[0], float)]
    for a, b in itertools.pairwise(corners):
        points += [np.array(a) + (np.array(b) - a) * k / parts for k in range(1, parts + 1)]
    return mesh(points, [(k, k + 1) for k in range(len(points) - 1)], **{n: parts * k for n, k in sets.items()})


def test_bracket_with_a_corner():
    """A post of the height a with an arm b: its tip sinks by P b^3 / 3 EI + P b^2 a / EI; corners join rigidly."""
    a, b, P = 1.5, 1.0, 1.0
    bracket = polyline((0, 0, 0), (0, 0, a), (b, 0, a), foot=0, tip=2)
    bodies, joints, markers = fmb.line_network(fmb.AncfBeam, "f", bracket, section=ROD, material=STEEL)
    assert [body.name for body in bodies] == ["f_1", "f_2"]
    assert [body.elements for body in bodies] == [5, 3]  # the mean length of the lines
    assert (markers["foot"], markers["tip"]) == ("f_1.foot", "f_2.tip")
    assert [type(joint) for joint in joints] == [fmb.Fixed]
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(), *bodies),
            gravity=(0, 0, 0),
            joints=(*joints, fmb.Fixed("clamp", markers=("ground.origin", markers["foot"]))),
            forces=(fmb.PointLoad("P", marker=markers["tip"], force=(0, 0, -P)),),
            sensors=(fmb.Position("tip", marker=markers["tip"]),),
        )
    )
    sinks = a - solution["tip"][-1, 2]
    assert sinks == pytest.approx(P * b**3 / (3 * EI) + P * b**2 * a / EI, rel=2e-3)


def test_three_ropes_and_a_weight():
    """Three ropes from a ring above to one node: each carries W / (3 cos) of their angle."""
    top = [(np.cos(x), np.sin(x), 0.0) for x in 2 * np.pi * np.arange(3) / 3]
    bodies, joints, markers = fmb.line_network(
        fmb.AncfCable,
        "rope",
        mesh([*top, (0, 0, -2.0)], [(0, 3), (3, 1), (2, 3)], a=0, b=1, c=2, low=3),
        size=0.6,
        section=ROD,
        material=fmb.Material(young=2e11, poisson=0.0, density=1e-3),
    )
    assert len(bodies) == 3
    assert [type(joint) for joint in joints] == [fmb.Spherical] * 2
    anchors = [fmb.Spherical(f"hold {name}", markers=(f"ground.{name}", markers[name])) for name in "abc"]
    weight = 900.0
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(markers=dict(zip("abc", top, strict=True))), *bodies),
            gravity=(0, 0, 0),
            joints=(*joints, *anchors),
            forces=(fmb.PointLoad("W", marker=markers["low"], force=(0, 0, -weight)),),
            sensors=[fmb.SectionForces(body.name, body=body.name, at=0.5) for body in bodies],
        )
    )
    tension = weight / 3.0 * np.sqrt(5.0) / 2.0
    for body in bodies:
        assert solution[body.name][-1, 0] == pytest.approx(tension, rel=1e-3)


def test_named_node_within_a_curve():
    """The marker is where the node is, although the spline is longer than the lines."""
    angle = np.linspace(0.0, 2.0, 11)
    arc = mesh(np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1), [(k, k + 1) for k in range(10)], here=3)
    bodies, joints, markers = fmb.line_network(fmb.AncfBeam, "bow", arc, section=ROD, material=STEEL)
    assert not joints
    pose = bodies[0].marker_poses()[markers["here"].partition(".")[2]]
    np.testing.assert_allclose(np.array(pose.at) + arc.points[0], arc.points[3], atol=1e-4)
    np.testing.assert_allclose(pose.matrix, np.eye(3), atol=SOLVER)


def test_rings():
    """A ring of cable is closed; one of beams is two halves."""
    angle = 2 * np.pi * np.arange(12) / 12
    ring = mesh(np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1), [(k, (k + 1) % 12) for k in range(12)])
    cable = fmb.line_network(fmb.AncfCable, "ring", ring, corner=1.0, section=ROD, material=STEEL)
    assert len(cable.bodies) == 1
    assert cable.bodies[0].closed
    assert cable.bodies[0].curve.length == pytest.approx(2 * np.pi, rel=1e-3)
    beams = fmb.line_network(fmb.AncfBeam, "ring", ring, corner=1.0, section=ROD, material=STEEL)
    assert (len(beams.bodies), len(beams.joints)) == (2, 2)
    assert fmb.check(fmb.Model(bodies=(fmb.Ground(), *beams.bodies), joints=beams.joints)).assembly_error < 1e-9


def test_model_file_names_a_mesh(tmp_path):
    """`points = "rope.vtu"`: the one line of the mesh in order; branches are refused with the node."""
    import meshio

    points = np.array([(2.0, 0, 0), (0, 0, 0), (1.0, 0, -0.1)])
    meshio.write(tmp_path / "rope.vtu", meshio.Mesh(points, [("line", np.array([[0, 2], [1, 2]]))]))
    text = """
[[body]]
kind = "Ground"
[[body]]
kind = "AncfCable"
name = "rope"
points = "rope.vtu"
elements = 6
section = { kind = "Section.solid_circle", diameter = 0.01 }
material = "steel"
"""
    (tmp_path / "model.toml").write_text(text)
    rope = fmb.load_model(tmp_path / "model.toml").body("rope")
    np.testing.assert_allclose(rope.points, points[[0, 2, 1]])
    branched = meshio.Mesh(np.vstack([points, (1.0, 1.0, 0)]), [("line", np.array([[0, 2], [1, 2], [2, 3]]))])
    meshio.write(tmp_path / "rope.vtu", branched)
    with pytest.raises(ModelError, match=r"rope\.vtu.*3 lines, which branch at node 2.*line_network"):
        fmb.load_model(tmp_path / "model.toml")


REFUSED = {
    "line 1 between the nodes": ([(0, 0, 0), (1, 0, 0), (1, 0, 0)], [(0, 1), (1, 2)]),
    "are joined by 2 lines": ([(0, 0, 0), (1, 0, 0)], [(0, 1), (1, 0)]),
}


@pytest.mark.parametrize("found", REFUSED)
def test_refused(found):
    with pytest.raises(ModelError, match=f"line_network 'n': .*{found}"):
        fmb.line_network(fmb.AncfCable, "n", mesh(*REFUSED[found]), section=ROD, material=STEEL)


def test_refused_without_lines():
    solid = fem.Mesh(points=np.eye(3), cells=(("triangle", np.array([[0, 1, 2]])),))
    with pytest.raises(ModelError, match="a mesh without line cells"):
        fmb.line_network(fmb.AncfBeam, "n", solid, section=ROD, material=STEEL)
    with pytest.raises(ModelError, match="AncfCable or AncfBeam"):
        fmb.line_network(fmb.RigidBody, "n", solid, section=ROD, material=STEEL)
