"""A meshed cantilever of silicon, 1 x 0.1 x 0.02 mm: from the mesh to motion, as for parts of any size.

References: Euler-Bernoulli, w = (beta / L)^2 sqrt(E I / (rho A)), tip m g L^3 / (8 E I); a load that is suddenly there
moves the tip by twice the static deflection, and by what higher modes add to it.
"""

import warnings

import meshio
import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

LENGTH, WIDTH, HEIGHT = 1e-3, 1e-4, 2e-5
SILICON = fmb.Material(young=169e9, poisson=0.0, density=2329.0)
BENDING = SILICON.young * WIDTH * HEIGHT**3 / 12.0
LINE = SILICON.density * WIDTH * HEIGHT


def write_mesh(path, unit: float = 1.0):
    """Write 20 x 2 x 1 hexahedra as Gmsh does, lengths in `unit` (m)."""
    count = (20, 2, 1)
    axes = [np.linspace(0, LENGTH, 21), np.linspace(-0.5, 0.5, 3) * WIDTH, np.linspace(-0.5, 0.5, 2) * HEIGHT]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape([n + 1 for n in count])
    low, high = [], []
    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
        layer = number[di : di + count[0], dj : dj + count[1]]
        low.append(layer[:, :, :-1].ravel())
        high.append(layer[:, :, 1:].ravel())
    tags = {"gmsh:physical": [np.ones(40, int)], "gmsh:geometrical": [np.ones(40, int)]}
    mesh = meshio.Mesh(points / unit, [("hexahedron", np.stack(low + high, axis=1))], cell_data=tags)
    meshio.write(path, mesh, file_format="gmsh22", binary=False)
    return path


def test_from_mesh_to_motion_without_a_doubt(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fe = fem.solid(fem.read_mesh(write_mesh(tmp_path / "beam.msh")), SILICON)
        ends = {name: np.flatnonzero(np.abs(fe.nodes[:, 0] - x) < 1e-12) for name, x in (("root", 0), ("tip", LENGTH))}
        data = reduction.reduce(fe, ends, modes=8)
        assert data.mass == pytest.approx(LINE * LENGTH, rel=1e-12)
        model = fmb.Model(
            gravity=(0, 0, -9.81),
            bodies=[fmb.Ground(), fmb.FloatingBody("beam", data=data)],
            joints=[fmb.Fixed("clamp", markers=("ground.origin", "beam.root"))],
            sensors=[fmb.Position("tip", marker="beam.tip")],
        )
        assert not fmb.check(model).notes
        assert not fmb.check(model).warnings
        still = fmb.statics(model)
        deflection = LINE * 9.81 * LENGTH**4 / (8.0 * BENDING)
        assert still["tip"][-1, 2] == pytest.approx(-deflection, rel=0.002)
        found = fmb.linearize(model, still).frequencies
        first = 1.875104**2 / (2.0 * np.pi * LENGTH**2) * np.sqrt(BENDING / LINE)
        np.testing.assert_allclose(found[[0, 2]], [first, first * (4.694091 / 1.875104) ** 2], rtol=0.006)
        moved = fmb.simulate(model, 2.0 / first, samples=81)
        assert moved["tip"][:, 2].min() == pytest.approx(-2.0 * deflection, rel=0.03)


def test_the_same_in_micrometres_is_doubted(tmp_path):
    """Numbers in micrometres read as metres: a kilometre of silicon."""
    mesh = fem.read_mesh(write_mesh(tmp_path / "beam.msh", unit=1e-6))
    with pytest.warns(fem.MeshWarning, match=r"the diagonal is 1005\.19 m"):
        fem.solid(mesh, SILICON)
