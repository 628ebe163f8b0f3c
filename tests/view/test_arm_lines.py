"""Rigid arms on elastic beams are drawn: joints and loads at their ends would hang in the air."""

from dataclasses import replace

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.io.scene import Scene
from flexmb.view.arm_lines import arm_lines
from flexmb.view.stage import Stage

STEEL = fmb.MATERIALS["steel"]
ARM = (0.02, 0.0, 0.4)


def clamped(arms=((2, ARM),)):
    """A cantilever of four beams, 2 m along y, with arms (node, offset) at its nodes, and its solution."""
    y = np.linspace(0.0, 2.0, 5)
    fe = fem.frame(np.column_stack([0 * y, y, 0 * y]), section=fem.Section.rectangle(0.04, 0.06), material=STEEL)
    stations = {}
    for number, (node, offset) in enumerate(arms):
        name = f"arm{number}"
        fe = fem.with_rigid_link(fem.with_node(fe, tuple(fe.nodes[node] + offset), name=name), node, name)
        stations[name] = [int(fe.node_sets[name][0])]
    data = reduction.reduce(fe, interfaces={"root": [0], "tip": [4]}, modes=2, stations=stations)
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("beam", data=data)],
        joints=[fmb.Fixed("wall", markers=("ground.origin", "beam.root"))],
        forces=[fmb.PointLoad("load", marker="beam.tip", force=(0.0, 0.0, 50.0))],
    )
    return fmb.statics(model)


def test_an_arm_stands_on_the_nearest_node_and_moves_with_the_beam():
    scene = Scene(clamped())
    part = scene.part("beam")
    ((kind, lines),) = arm_lines(part)
    assert kind == "line"
    ends = part.points[lines]
    np.testing.assert_allclose(ends, [[(0, 1, 0), (0.02, 1, 0.4)]], atol=1e-12)
    stage = Stage(scene, (200, 100), 0.0)
    try:
        stage.add_state(len(scene.times) - 1)
        drawn = next(surface for part, surface, *_ in stage._drawn if part.name == "beam")
        assert drawn.n_lines == 5  # four beams and the arm
        moved = scene.snapshot(part, len(scene.times) - 1).points
        top = moved[lines[0, 1]]
        assert top[2] - 0.4 > 1e-4
        assert np.linalg.norm(drawn.points - top, axis=1).min() < 1e-6
    finally:
        stage.close()


@pytest.mark.parametrize(("arms", "count"), [((), 0), (((2, ARM), (4, ARM), (4, (-0.3, 0.0, 0.0))), 3)])
def test_as_many_as_there_are(arms, count):
    part = Scene(clamped(arms)).part("beam")
    assert sum(len(rows) for _, rows in arm_lines(part)) == count


def test_shells_and_solids_have_none():
    """A free node of theirs is the middle of a bore or the like, and no end of an arm."""
    part = Scene(clamped()).part("beam")
    assert arm_lines(replace(part, cells=(*part.cells, ("triangle", np.array([[0, 1, 2]]))))) == ()
