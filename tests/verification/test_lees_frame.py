"""Lee's frame: two members at a right angle, pinned at their ends, under a load on the horizontal one; it snaps back.

Lee, Manuel & Rossow 1968; Schweizerhof & Wriggers 1986. Reference: the extensible elastica, solved by shooting at the
displacement of the load that was found. Published limit loads P L^2 / EI of 18.5 belong to the same data.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import flexmb as fmb
from flexmb import fem

LENGTH, EA, EI, AT = 1.2, 4320.0, 0.144, 0.2
TO_Y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Axes with z along the y-axis of W: what the joint at the corner holds."""


def frame(elements: int = 20):
    """Return the frame; the load grows by 20 N per unit of time."""
    material = fmb.Material(young=7.2e6, poisson=0.0, density=1000.0)
    section = fem.Section.values(EA / 7.2e6, EI / 7.2e6, EI / 7.2e6, 2 * EI / 7.2e6)
    L, up = LENGTH, np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    column = fmb.AncfCable(
        "column",
        points=((0, 0, 0), (0, 0, L)),
        elements=elements,
        section=section,
        material=material,
        markers={"corner": (1.0, up.T @ TO_Y)},
    )
    beam = fmb.AncfCable(
        "beam",
        points=((0, 0, L), (L, 0, L)),
        elements=elements,
        section=section,
        material=material,
        markers={"P": AT, "corner": (0.0, TO_Y)},
    )
    return fmb.Model(
        bodies=(fmb.Ground(markers={"B": (L, 0, L)}), column, beam),
        gravity=(0, 0, 0),
        joints=(
            fmb.Spherical("foot", markers=("ground.origin", "column.start")),
            fmb.Fixed("corner", markers=("column.corner", "beam.corner")),
            fmb.Spherical("end", markers=("ground.B", "beam.end")),
        ),
        forces=(fmb.PointLoad("P", marker="beam.P", force=(0, 0, fmb.expression("-20*t"))),),
        sensors=(fmb.Position("load", marker="beam.P"), fmb.Reaction("foot", joint="foot")),
    )


def _member(S, y, F):
    angle, moment = y[2:]
    t = np.array([np.cos(angle), np.sin(angle)])
    dx, dz = (1.0 + F @ t / EA) * t
    return dx, dz, moment / EI, -(dx * F[1] - dz * F[0])


def elastica(height: float, guess):
    """Return load, and reactions (2,) at the foot, when the loaded point is at `height`;
    guess: (P, R_x, R_z, angle).
    """

    def shoot(unknowns):
        P, Rx, Rz, angle = unknowns
        y, F = np.array([0.0, 0.0, angle, 0.0]), -np.array([Rx, Rz])
        for length, turn, load in ((LENGTH, -0.5 * np.pi, 0.0), (AT * LENGTH, 0.0, P), ((1 - AT) * LENGTH, 0.0, 0.0)):
            y = solve_ivp(_member, (0.0, length), y, args=(F,), rtol=1e-10, atol=1e-12).y[:, -1]
            y[2] += turn
            if load:
                gap, F = y[1] - height, F + np.array([0.0, load])
        return gap, y[0] - LENGTH, y[1] - LENGTH, y[3]

    found, _, success, _ = fsolve(shoot, guess, xtol=1e-12, full_output=True)
    assert success == 1
    return found


@pytest.fixture(scope="module")
def path():
    return fmb.statics(frame(), t=0.5, path=fmb.ArcLength(points=200))


def test_extrema_of_the_load(path):
    """The load rises to 18.5 EI / L^2, falls below zero and rises again; both extrema within 1e-3 of the elastica's."""
    extrema = [point for point in path.limit_points if point.kind != "bifurcation"]
    assert [point.kind for point in extrema] == ["maximum", "minimum"]
    assert 20.0 * extrema[0].load * LENGTH**2 / EI == pytest.approx(18.5, abs=0.06)
    for point in extrema:
        assert path.factor[point.sample] == point.load
    assert path.status.kind == "finished"
    assert path.factor[-1] == 0.5


@pytest.mark.parametrize("fraction", [0.1, 0.25, 0.45, 0.6, 0.75, 0.95])
def test_path_is_that_of_the_elastica(path, fraction):
    """Load and reactions at the same displacement, before and after both extrema."""
    k = int(fraction * (len(path.t) - 1))
    Rx, Rz = path["foot"][k, [0, 2]]
    tangent = path.phases[0].q[k, 3:6]
    found = elastica(path["load"][k, 2], (20.0 * path.t[k], Rx, Rz, np.arctan2(tangent[2], tangent[0])))
    np.testing.assert_allclose([20.0 * path.t[k], Rx, Rz], found[:3], atol=2e-3 * np.abs(found[:3]).max())
