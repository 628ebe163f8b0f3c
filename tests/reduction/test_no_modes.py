"""Reductions that leave little: no modes at all, or a model that lies in a plane; both go into mechanisms.

The references are those of rigid bodies: mass and inertia of a slender rod, and the compound pendulum's half swing.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

STEEL = fmb.Material(young=210e13, poisson=0.3, density=7850.0)  # bends too little to matter


def rod():
    """Return the frame model of a rod of 1 m, 20 x 10 mm, along x."""
    section = fem.Section.rectangle(0.01, 0.02)
    return fem.frame(points=np.linspace((0, 0, 0), (1, 0, 0), 5), section=section, material=STEEL)


def pendulum(data):
    """Return a rod that swings about z from the horizontal."""
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("rod", data=data)],
        joints=[fmb.Revolute("A", markers=("ground.origin", "rod.a"))],
        gravity=(0, -9.81, 0),
        sensors=[fmb.JointCoordinate("angle", joint="A")],
    )


def swing(t):
    """Return the angle at time t of a rod of 1 m hinged at its end, from the horizontal: J phi'' = -m g l/2 cos phi."""
    from scipy.integrate import solve_ivp

    J = 1.0 / 3.0 + 0.01**2 / 12.0  # per mass
    return solve_ivp(
        lambda _, y: (y[1], -9.81 * 0.5 / J * np.cos(y[0])), (0.0, t), (0.0, 0.0), rtol=1e-10, atol=1e-12
    ).y[0, -1]


def test_one_interface_and_no_modes_give_a_rigid_body():
    data = reduction.reduce(rod(), {"a": "start"}, 0)
    assert len(data.frequencies) == 0
    assert data.mass == pytest.approx(7850.0 * 2e-4)
    np.testing.assert_allclose(data.center_of_mass, (0.5, 0, 0), atol=1e-12)
    solution = fmb.simulate(pendulum(data), 0.8)
    assert solution["angle"][-1] == pytest.approx(swing(0.8), abs=1e-4)


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.Implicit(), fmb.IDA()], ids=repr)
def test_a_planar_model_moves_in_its_plane(integrator):
    """Freedoms across the plane have no inertia: the joint holds them. (A short time: IDA follows all undamped
    vibrations of the rod, up to 285 kHz.)"""
    t = 0.02
    planar = fem.with_supports(rod(), directions=(2, 3, 4))
    data = reduction.reduce(planar, {"a": "start", "b": "end"}, 2)
    solution = fmb.simulate(pendulum(data), t, integrator=integrator)
    assert solution["angle"][-1] == pytest.approx(swing(t), abs=1e-6)


def test_a_planar_model_that_nothing_holds_across_its_plane_is_named():
    planar = fem.with_supports(rod(), directions=(2, 3, 4))
    data = reduction.reduce(planar, {"a": "start", "b": "end"}, 2)
    model = fmb.Model(bodies=[fmb.Ground(), fmb.FloatingBody("rod", data=data)])
    with pytest.raises(fmb.CompileError, match="Body 'rod'"):
        fmb.simulate(model, 0.1)
