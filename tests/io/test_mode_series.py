"""Modes for ParaView: VTK's own reader finds the shapes and stresses of the data."""

from dataclasses import replace

import numpy as np
import pytest
from reduction.solids import block

from flexmb import fem, reduction
from flexmb.errors import DataFileError
from flexmb.io import write_modes
from flexmb.model.material import Material
from flexmb.results import recover

STEEL = Material(young=210e9, poisson=0.3, density=7850.0)


@pytest.fixture(scope="module")
def data():
    return reduction.reduce(block(divisions=(4, 1, 1)), {"a": "left"}, modes=4, compare=0)


def test_series_of_modes(data, tmp_path):
    """Step n is mode n: points = nodes + displacement, a tenth of the size at most; stress of the same amplitude."""
    import pyvista

    path = write_modes(data, tmp_path / "out" / "block.pvd")
    reader = pyvista.get_reader(path)
    np.testing.assert_array_equal(reader.time_values, np.arange(1.0, data.n_modes + 1))
    size = np.linalg.norm(np.ptp(data.nodes, axis=0))
    for j in range(data.n_modes):
        reader.set_active_time_value(j + 1.0)
        (mesh,) = reader.read()
        u = mesh.point_data["displacement"].astype(float)
        np.testing.assert_allclose(np.linalg.norm(u, axis=1).max(), 0.1 * size, rtol=1e-6)
        amplitude = np.vdot(u, data.shapes[:, :, j]) / np.vdot(data.shapes[:, :, j], data.shapes[:, :, j])
        np.testing.assert_allclose(u, amplitude * data.shapes[:, :, j], atol=1e-6 * size)
        np.testing.assert_allclose(mesh.points, data.nodes + u, atol=1e-6)
        stress = amplitude * data.stress_modes[:, :, j]
        scale = np.abs(stress).max()
        np.testing.assert_allclose(mesh.point_data["stress"], stress, atol=1e-6 * scale)
        np.testing.assert_allclose(mesh.point_data["von_mises"], recover.von_mises(stress), atol=1e-5 * scale)


def test_frames_turn(tmp_path):
    import pyvista

    fe = fem.frame([(0, 0, 0), (1, 0, 0), (2, 0, 0)], section=fem.Section.rectangle(0.02, 0.03), material=STEEL)
    data = reduction.reduce(fe, {"a": "start"}, modes=2, compare=0)
    reader = pyvista.get_reader(write_modes(data, tmp_path / "beam.pvd", modes=[1]))
    np.testing.assert_array_equal(reader.time_values, [2.0])
    (mesh,) = reader.read()
    turn, shape = mesh.point_data["rotation"], data.rotation_shapes[:, :, 1]
    np.testing.assert_allclose(turn / np.linalg.norm(turn), shape / np.linalg.norm(shape), atol=1e-6)


@pytest.mark.parametrize(
    ("change", "name", "modes", "match"),
    [
        (
            {},
            "x.vtu",
            None,
            r"VTK output '.*x\.vtu': the ending '\.vtu'\. Expected: \.pvd\. Modes are written as a PVD",
        ),
        ({"cells": ()}, "x.pvd", None, r"Modes of 'block': the data has no cells\. Expected: a mesh to draw"),
        ({}, "x.pvd", [99], r"Modes of 'block': modes \[99\]\. Expected: some of 0 to 3\. Choose among data\.freq"),
        ({}, "x.pvd", 0, r"Modes of 'block': modes 0"),
    ],
)
def test_messages(data, tmp_path, change, name, modes, match):
    with pytest.raises(DataFileError, match=match):
        write_modes(replace(data, **change), tmp_path / name, modes=modes)
