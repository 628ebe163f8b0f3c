"""Splitting an FE model: nothing is lost, sets go with their nodes, and what cannot be divided is refused."""

import numpy as np
import pytest
from tolerances import MACHINE

import flexmb as fmb
from flexmb import fem

STEEL = fmb.MATERIALS["steel"]


def bar(lumped=False):
    """A bar of 8 x 1 x 1 hexahedra along x with its ends as sets."""
    n = 8
    grid = np.stack(np.meshgrid(np.linspace(0, 2, n + 1), [0, 0.2], [0, 0.2], indexing="ij"), axis=-1)
    points = grid.reshape(-1, 3)
    corner = 4 * np.arange(n)[:, None] + np.array([0, 4, 6, 2, 1, 5, 7, 3])
    sets = {"root": np.flatnonzero(points[:, 0] == 0.0), "tip": np.flatnonzero(points[:, 0] == 2.0)}
    mesh = fem.Mesh(points=points, cells=(("hexahedron", corner),), node_sets=sets)
    return fem.solid(mesh, STEEL, lumped=lumped)


def frame(lumped=False):
    """A tapered beam: the tables of its sections have one row per element."""
    sections = [fem.Section.rectangle(0.02, 0.03), fem.Section.rectangle(0.01, 0.02)]
    return fem.frame(np.linspace([0, 0, 0], [2, 0, 0], 9), section=sections, material=STEEL, lumped=lumped)


def plate(lumped=False):
    x, y = np.meshgrid(np.linspace(0, 2, 9), [0, 0.3], indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(18)])
    cells = 2 * np.arange(8)[:, None] + np.array([0, 2, 3, 1])
    mesh = fem.Mesh(points=points, cells=(("quad", cells),))
    return fem.shell(mesh, thickness=0.01, material=STEEL, lumped=lumped)


def energy(fe, matrix, displacement):
    """u^T A u of a field given as a function of the place."""
    u = displacement(fe.nodes)[fe.dofs[:, 0], fe.dofs[:, 1]]
    return u @ (matrix @ u)


@pytest.mark.parametrize("lumped", [False, True])
@pytest.mark.parametrize("make", [bar, frame, plate])
def test_energies_add_up(make, lumped):
    """Strain and kinetic energy of any motion are those of the whole (a sum over elements)."""
    fe = make(lumped)
    parts = fem.split(fe, at=(0.5, 1.5))
    amplitude = np.random.default_rng(3).normal(size=(3, 6))

    def motion(x):
        return np.sin(x @ amplitude) + 0.1 * x @ amplitude

    for whole, of in ((fe.K, "K"), (fe.M, "M")):
        total = sum(energy(p, getattr(p, of), motion) for p in parts)
        assert total == pytest.approx(energy(fe, whole, motion), rel=MACHINE)
    assert [len(b.connectivity) for p in parts for b in p.blocks] == [2, 4, 2]


def test_sets_and_cuts():
    first, middle, last = fem.split(bar(), at=(0.5, 1.5))
    assert set(first.node_sets) == {"root", "cut_1_2"}
    assert set(middle.node_sets) == {"cut_1_2", "cut_2_3"}
    assert set(last.node_sets) == {"tip", "cut_2_3"}
    np.testing.assert_array_equal(middle.nodes[middle.node_sets["cut_2_3"]], last.nodes[last.node_sets["cut_2_3"]])
    assert np.all(first.nodes[first.node_sets["cut_1_2"], 0] == 0.5)


def test_labels_instead_of_planes():
    parts = fem.split(bar(), labels=[1, 1, 2, 2, 2, 2, 3, 3])
    planes = fem.split(bar(), at=(0.5, 1.5))
    assert len(parts) == 3
    for a, b in zip(parts, planes, strict=True):
        np.testing.assert_array_equal(a.nodes, b.nodes)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"at": (0.5, 0.5)}, r"at = \(0.5, 0.5\).*increasing distances"),
        ({"at": (0.5, 3.0)}, r"elements in the parts \[1, 2\].*inside the body"),
        ({}, "at = None"),
        ({"labels": [1, 2]}, "2 labels.*8 integers"),
    ],
)
def test_messages(options, told):
    with pytest.raises(fmb.MeshError, match=told):
        fem.split(bar(), **options)


def test_more_than_elements_is_refused():
    with pytest.raises(fmb.MeshError, match=r"mass matrix that is not the sum.*add masses"):
        fem.split(fem.with_mass(frame(), "end", 1.0), at=(1.0,))
    with pytest.raises(fmb.MeshError, match=r"links between nodes.*Split first"):
        fem.split(fem.with_rigid_link(frame(), "start", "end"), at=(1.0,))


def test_separate_pieces_are_refused():
    two = fem.frame(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]],
        connectivity=[[0, 1], [2, 3]],
        section=fem.Section.rectangle(0.1, 0.1),
        material=STEEL,
    )
    with pytest.raises(fmb.MeshError, match="part 1 shares no node"):
        fem.split(two, at=(1.5,))
