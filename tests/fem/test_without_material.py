"""A mesh without a material is refused in words."""

import numpy as np
import pytest

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.fem.meshes.mesh import Mesh


@pytest.mark.parametrize(("make", "words"), [(fem.solid, "fem.solid(mesh, "), (fem.shell, "thickness=0.002")])
def test_a_mesh_has_no_material(make, words):
    mesh = Mesh(points=np.vstack([np.zeros(3), np.eye(3)]), cells=(("tetra", np.array([(0, 1, 2, 3)])),))
    with pytest.raises(MeshError, match="no material") as told:
        make(mesh)
    assert words in str(told.value)
