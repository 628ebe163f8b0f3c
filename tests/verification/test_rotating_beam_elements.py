"""A rotating beam from solids, frames and shells: frequencies against speed.

Spinning about an axis across it (a blade): flap and chord of GS04 (Wright et al. 1982). Spinning about its own axis (a
shaft), where the Coriolis force couples both planes: with the same shapes in both planes, the frequencies at rest p and
q become those s of (p^2 - W^2 - s^2) (q^2 - W^2 - s^2) = 4 W^2 s^2, equation by equation, in the turning frame
(Dimentberg, Flexural Vibrations of Rotating Shafts, 1961); p and q are those of Euler and Bernoulli, and a beam of 2 %
thickness differs from theirs by 0.1 % in the first mode and 0.6 % in the second.
"""

import numpy as np
import pytest
from fem.beams import plate
from fem.structured import structured

import flexmb as fmb
from flexmb import fem, reduction

THICKNESS = 0.02
WIDTH = 0.04
MATERIAL = fmb.Material(young=2e11, poisson=0.0, density=8000.0)
UNIT = np.sqrt(MATERIAL.young * THICKNESS**2 / 12.0 / MATERIAL.density)
"""sqrt(E I / (rho A L^4)) of flapping, bending through the thickness along z; chord is WIDTH / THICKNESS times it."""


def model(kind):
    """Return the FE model of a unit beam along x, width along y, thickness along z."""
    if kind == "frame":
        return fem.frame(
            np.linspace([0, 0, 0], [1, 0, 0], 31), section=fem.Section.rectangle(WIDTH, THICKNESS), material=MATERIAL
        )
    if kind == "shell":
        mesh = plate(40, 4, 1.0, WIDTH, "quad")
        fe = fem.shell(mesh, MATERIAL, THICKNESS)
    else:
        mesh = structured("hexahedron20", (16, 1, 1), (1.0, WIDTH, THICKNESS))
        fe = fem.solid(mesh, MATERIAL)
    return fe


@pytest.fixture(scope="module", params=["frame", "solid", "shell"])
def data(request):
    fe = model(request.param)
    root = np.flatnonzero(fe.nodes[:, 0] < 1e-9)
    tip = np.flatnonzero(fe.nodes[:, 0] > 1 - 1e-9)
    return reduction.reduce(fe, {"root": root}, 12, stations={"tip": tip}, geometric_stiffness=True, stress=False)


def planes(data, linear):
    """Return the frequencies, rad/s, of modes that move the tip along y and along z."""
    translation = data.marker_translations[1] @ linear.modes[-data.n_modes :]
    along = np.abs(translation) / np.linalg.norm(translation, axis=0)
    frequencies = 2.0 * np.pi * linear.frequencies
    return frequencies[along[1] > 0.9], frequencies[along[2] > 0.9]


@pytest.mark.parametrize("eta", [0, 2, 6])
def test_blade(data, reference, eta):
    """Two modes in both planes; `eta` in units of the flap frequency."""
    case, ratio = reference("GS04")["reference"], WIDTH / THICKNESS
    body = fmb.FloatingBody("beam", data=data, at=(0, -data.marker_positions[0][1], 0))
    blade = fmb.Model(
        bodies=[fmb.Ground(), body],
        joints=[
            fmb.Revolute("hub", markers=("ground.origin", "beam.root")),
            fmb.Drive("spin", joint="hub", angle=fmb.expression("w * t", w=eta * UNIT)),
        ],
    )
    chord, flap = planes(data, fmb.linearize(blade, fmb.statics(blade)))
    np.testing.assert_allclose(flap[:2] / UNIT, case["flap"][str(eta)][:2], rtol=8e-3)
    np.testing.assert_allclose(chord[:2] / UNIT / ratio, case["chord"][str(int(eta / ratio))][:2], rtol=1.2e-2)


@pytest.mark.parametrize("share", [0.0, 0.4, 0.8])
def test_shaft(data, share):
    """Speeds below the first critical one: it whirls forward and backward, faster and slower than at rest."""
    first = 1.87510407**2 * UNIT
    speed, p, q = share * first, first, first * WIDTH / THICKNESS
    along = fmb.Pose.axes(data.marker_positions[0], z=(1, 0, 0), x=(0, 1, 0))
    body = fmb.FloatingBody("beam", data=data, at=-data.marker_positions[0], markers={"root": along})
    shaft = fmb.Model(
        bodies=[fmb.Ground(markers={"bearing": fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 1, 0))}), body],
        joints=[
            fmb.Revolute("bearing", markers=("ground.bearing", "beam.root")),
            fmb.Drive("spin", joint="bearing", angle=fmb.expression("w * t", w=float(speed))),
        ],
    )
    found = 2.0 * np.pi * fmb.linearize(shaft, fmb.statics(shaft)).frequencies[:2]
    a, b = p**2 - speed**2, q**2 - speed**2
    # s^4 - (a + b + 4 W^2) s^2 + a b = 0
    expected = np.sqrt(np.sort(np.roots([1.0, -(a + b + 4 * speed**2), a * b])))
    np.testing.assert_allclose(found, expected, rtol=5e-3)
