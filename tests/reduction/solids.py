"""Small solid FE models for the tests: a block of quadratic tetrahedra with named ends."""

import numpy as np

from flexmb import fem
from flexmb.fem.meshes.mesh import Mesh
from flexmb.model.material import Material

STEEL = Material(young=210e9, poisson=0.3, density=7850.0)


def block_mesh(size=(0.4, 0.06, 0.04), divisions=(6, 2, 1)) -> Mesh:
    """tet10 block from the origin: sets "left", "right", "mid" (a ring of nodes), facets "top" (z = height) and
    "skin" (all around)."""
    from skfem import MeshTet, MeshTet2

    straight = MeshTet.init_tensor(*(np.linspace(0.0, s, n + 1) for s, n in zip(size, divisions, strict=True)))
    mesh = MeshTet2.from_mesh(straight)
    points = mesh.doflocs.T.copy()
    edges = len(straight.p.T) + straight.t2e[[0, 1, 2, 3, 4, 5]].T
    cells = np.hstack([straight.t.T, edges])
    x, _, z = points.T
    faces = ((0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (0, 3, 2, 7, 9, 6))
    every = np.vstack([cells[:, face] for face in faces])
    inside = np.tile(points[cells[:, :4]].mean(axis=1), (4, 1))
    normal = np.cross(points[every[:, 1]] - points[every[:, 0]], points[every[:, 2]] - points[every[:, 0]])
    inward = np.einsum("ij,ij->i", normal, points[every[:, 0]] - inside) < 0.0
    every[inward] = every[inward][:, [0, 2, 1, 5, 4, 3]]
    on_top = np.all(np.isclose(z[every], size[2]), axis=1)
    _, where, once = np.unique(np.sort(every[:, :3], axis=1), axis=0, return_inverse=True, return_counts=True)
    return Mesh(
        points=points,
        cells=(("tetra10", cells),),
        node_sets={
            "left": np.flatnonzero(x < 1e-9),
            "right": np.flatnonzero(x > size[0] - 1e-9),
            "mid": np.flatnonzero(np.isclose(x, size[0] / 2)),
            "edge": np.flatnonzero((x < 1e-9) & (z < 1e-9)),
        },
        facet_sets={"top": every[on_top], "skin": every[once[where] == 1]},
        name="block",
    )


def block(size=(0.4, 0.06, 0.04), divisions=(6, 2, 1)):
    """The block as an FE model of steel."""
    return fem.solid(block_mesh(size, divisions), STEEL)
