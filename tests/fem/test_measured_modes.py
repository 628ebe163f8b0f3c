"""Modes of a test from universal files, and how alike computed ones are."""

import numpy as np
import pytest
from fem.beams import straight

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.model.material import Material

STEEL = Material(young=210e9, poisson=0.3, density=7850.0)

WRITTEN = """    -1
    55
Modes of a beam
NONE
NONE
NONE
NONE
         1         2         2         8         2         3
         2         4         1         1
  1.25000e+01  1.00000e+00  1.10000e-02  0.00000e+00
         2
  0.00000e+00  0.00000e+00  1.20000e-01
         3
  0.00000e+00  0.00000e+00 -5.00000e-01
    -1
    -1
    55
c
NONE
NONE
NONE
NONE
         1         3         2         8         5         3
         2         6         1         3
 -3.00000e+00  3.00000e+02  1.00000e+00  0.00000e+00  1.00000e+00  0.00000e+00
         2
  0.00000e+00  0.00000e+00  0.00000e+00  0.00000e+00  1.00000e-01  2.00000e-02
         3
  0.00000e+00  0.00000e+00  0.00000e+00  0.00000e+00-5.000000e-01-1.000000e+00
    -1
"""
"""Two modes of three directions, real and complex, in the form in which pyuff 2.5.8 writes them."""


def written(path, shapes, frequencies, labels):
    """Write real modes (n, p, 3) as datasets 55 of six directions."""
    text = ""
    for k, (shape, frequency) in enumerate(zip(shapes, frequencies, strict=True)):
        text += "    -1\n    55\n" + "NONE\n" * 5 + f"{1:10d}{2:10d}{3:10d}{8:10d}{2:10d}{6:10d}\n"
        text += f"{2:10d}{4:10d}{1:10d}{k + 1:10d}\n{frequency:13.5E}{1.0:13.5E}{0.01:13.5E}{0.0:13.5E}\n"
        for label, row in zip(labels, shape, strict=True):
            text += f"{label:10d}\n" + "".join(f"{x:13.5E}" for x in [*row, 9.0, 9.0, 9.0]) + "\n"
        text += "    -1\n"
    path.write_text(text)
    return path


def test_real_and_complex_modes(tmp_path):
    path = tmp_path / "test.unv"
    path.write_text(WRITTEN)
    found = fem.read_measured_modes(path)
    np.testing.assert_allclose(found.frequencies, [12.5, np.hypot(3.0, 300.0) / (2 * np.pi)])
    np.testing.assert_allclose(found.damping, [0.011, 3.0 / np.hypot(3.0, 300.0)])
    np.testing.assert_array_equal(found.labels, [2, 3])
    np.testing.assert_allclose(found.shapes[:, :, 2], [[0.12, -0.5], [0.1 + 0.02j, -0.5 - 1.0j]])


def test_assurance_of_a_cantilever(tmp_path):
    """Five points of a cantilever that measure z: the shapes of clamped-free Bernoulli beams (closed form) are the
    computed ones; the modes across have no part in it.
    """
    fe = fem.frame(points=straight(40, 2.0), section=fem.Section.rectangle(0.02, 0.03), material=STEEL)
    modes = fem.eigenmodes(fe, [0], 6)
    bending_z = [k for k in range(6) if np.abs(fe.field(modes.shapes)[-1, 2, k]) > 1e-6]
    roots = [1.8751040687, 4.6940911330, 7.8547574382]
    x = np.array([0.4, 0.8, 1.2, 1.6, 2.0])
    shapes = np.zeros((3, 5, 3))
    for k, root in enumerate(roots):
        s = (np.cosh(root) + np.cos(root)) / (np.sinh(root) + np.sin(root))
        b = root * x / 2.0
        shapes[k, :, 2] = 100.0 * (np.cosh(b) - np.cos(b) - s * (np.sinh(b) - np.sin(b)))
    measured = fem.read_measured_modes(written(tmp_path / "t.unv", shapes, [1.0, 2.0, 3.0], [11, 12, 13, 14, 15]))
    nodes = {11 + k: int(np.abs(fe.nodes[:, 0] - at).argmin()) for k, at in enumerate(x)}
    mac = fem.modal_assurance(fe, modes, measured, nodes)
    assert mac.shape == (3, 6)
    np.testing.assert_allclose(np.diag(mac[:, bending_z[:3]]), 1.0, atol=1e-3)
    a = shapes[:, :, 2]
    expected = (a @ a.T) ** 2 / np.outer((a**2).sum(axis=1), (a**2).sum(axis=1))
    np.testing.assert_allclose(mac[:, bending_z[:3]], expected, atol=2e-3)
    assert expected[0, 1] > 0.001  # points that are few do not separate modes wholly
    others = [k for k in range(6) if k not in bending_z]
    assert len(others) == 3
    assert mac[:, others].max() < 1e-9


def test_a_phase_does_not_matter(tmp_path):
    path = tmp_path / "test.unv"
    path.write_text(WRITTEN)
    found = fem.read_measured_modes(path)
    fe = fem.frame(points=straight(2), section=fem.Section.rectangle(0.02, 0.03), material=STEEL)
    modes = fem.eigenmodes(fe, [0], 4)
    nodes = {2: 1, 3: 2}
    turned = fem.MeasuredModes(
        frequencies=found.frequencies,
        damping=found.damping,
        labels=found.labels,
        shapes=found.shapes * np.exp(0.7j),
        name="t",
    )
    first, second = (fem.modal_assurance(fe, modes, each, nodes) for each in (found, turned))
    np.testing.assert_allclose(first, second, rtol=1e-12, atol=1e-15)


def test_what_cannot_be_compared_is_named(tmp_path):
    path = tmp_path / "test.unv"
    with pytest.raises(MeshError, match="no such file"):
        fem.read_measured_modes(path)
    path.write_text("    -1\n   151\nmodel\n    -1\n")
    with pytest.raises(MeshError, match="no modes; its datasets are 151"):
        fem.read_measured_modes(path)
    path.write_text(WRITTEN.replace("  1.20000e-01", "  hello"))
    with pytest.raises(MeshError, match="in dataset 55"):
        fem.read_measured_modes(path)
    path.write_text(WRITTEN.replace("         3\n  0.00000e+00  0.00000e+00 -5.0", "         4\n  0. 0. -5.0"))
    with pytest.raises(MeshError, match="mode 2 has other points than mode 1"):
        fem.read_measured_modes(path)
    path.write_text(WRITTEN)
    found = fem.read_measured_modes(path)
    fe = fem.frame(points=straight(2), section=fem.Section.rectangle(0.02, 0.03), material=STEEL)
    modes = fem.eigenmodes(fe, [0], 2)
    with pytest.raises(MeshError, match="node 2"):
        fem.modal_assurance(fe, modes, found)
    with pytest.raises(MeshError, match="no measured direction"):
        fem.modal_assurance(fe, modes, found, {})
    with pytest.raises(MeshError, match=r"point 3 of 'test\.unv' at 77"):
        fem.modal_assurance(fe, modes, found, {2: 1, 3: 77})
