"""Bodies in absolute nodal coordinates at random states: far from their initial line, strained, moving."""

from __future__ import annotations

import numpy as np
import pytest
from contracts.random_models import derivative, moved
from tolerances import MACHINE

import flexmb as fmb
from flexmb import fem
from flexmb.integrate.matrices import tangent_at
from flexmb.math.energies import stored_energies
from flexmb.system import compile
from flexmb.system.program import energies, evaluate

H = 1e-3
"""Step of differences."""

SOFT = fmb.Material(young=3e3, poisson=0.3, density=900.0)
ROUND = fem.Section.solid_circle(0.2)
BENT = ((0, 0, 0), (0.4, 0.2, 0.1), (0.9, 0.3, 0.4), (1.2, 0.1, 0.3))


def cable(**fields) -> fmb.AncfCable:
    """A soft, damped, curved cable of three elements with a marker inside the second."""
    return fmb.AncfCable(
        "b",
        **{
            "points": BENT,
            "elements": 3,
            "section": ROUND,
            "material": SOFT,
            "axial_damping": 5.0,
            "bending_damping": 0.4,
            "initial_strain": 0.03,
            "markers": {"m": (0.45, (0.3, -0.2, 0.5))},
            **fields,
        },
    )


def disturbed(model, rng, size: float = 0.08):
    """Return the compiled system with all coordinates of its bodies without frames disturbed, moving, accelerated."""
    system = compile(model)
    state = system.state(0.2)
    state.u[:], state.a[:] = rng.normal(size=system.nu), rng.normal(size=system.nu)
    state.lam[:] = rng.normal(size=system.ng)
    for iq, _, count, flexible in system.program.vectors:
        if not flexible:
            state.q[iq : iq + count] += size * rng.normal(size=count)
    return system, state


def residual(system, state, work):
    """Return M a - forces - G^T lam."""
    work.weights[0].wanted = 0
    evaluate(system.program, state, work)
    return work.residual.copy()


def assert_tangent_is_the_derivative(system, state, tolerance=1e-8):
    """Mass, damping and stiffness are differences of the residual."""
    work = system.workspace()
    tangent = tangent_at(system, state, work)
    changes = {
        "M": lambda x, d: state._replace(a=state.a + x * d),
        "D": lambda x, d: state._replace(u=state.u + x * d),
        "K": lambda x, d: moved(system, state, d, x),
    }
    for name, change in changes.items():
        expected = np.array(
            [derivative(lambda x, d=d, c=change: residual(system, c(x, d), work), H) for d in np.eye(system.nu)]
        ).T
        found = getattr(tangent, name).toarray()
        np.testing.assert_allclose(found, expected, atol=tolerance * max(1.0, np.abs(expected).max()), err_msg=name)


def _in_motion(system, state, x):
    """Return the state of the motion with the accelerations of `state` a time x later."""
    return moved(system, state, state.u * x + 0.5 * state.a * x * x, 1.0, u=state.u + x * state.a)


def dissipation_beside_the_energy(body, rng) -> float:
    """Assert u . (M a + h) = d(T + U + V)/dt + dissipated power, without loads; return the dissipated power."""
    system, state = disturbed(fmb.Model(bodies=(fmb.Ground(), body), gravity=(1.0, -2.0, -9.0)), rng)
    work = system.workspace()

    def energy(x):
        energies(system.program, _in_motion(system, state, x), work)
        return stored_energies(work.energy).sum()

    change = derivative(energy, H)
    power = state.u @ residual(system, state, work)
    assert power == pytest.approx(change + work.energy[0].dissipation, rel=1e-8)
    return float(work.energy[0].dissipation)


def assert_marker_moves_as_its_jacobian_says(system, state, name):
    """Velocity, spin and bias acceleration of a marker are those of its motion; return the marker."""
    work, number = system.workspace(), system.marker_index[name]

    def pose(x):
        residual(system, _in_motion(system, state, x), work)
        marker = work.markers[number]
        return np.concatenate([marker["r"], marker["R"].ravel(), marker["v"], marker["w"]])

    rate = derivative(pose, H)
    residual(system, state, work)
    marker = work.markers[number].copy()
    J = work.J[marker["iJ"] : marker["iJ"] + 6 * marker["nu"]].reshape(6, -1)
    u, a = (x[marker["iu"] : marker["iu"] + marker["nu"]] for x in (state.u, state.a))
    np.testing.assert_allclose(J @ u, np.concatenate([marker["v"], marker["w"]]), atol=1e2 * MACHINE)
    np.testing.assert_allclose(rate[:3], marker["v"], atol=1e-8)
    spin = rate[3:12].reshape(3, 3) @ marker["R"].T
    np.testing.assert_allclose([spin[2, 1], spin[0, 2], spin[1, 0]], marker["w"], atol=1e-7)
    np.testing.assert_allclose(rate[12:], J @ a + marker["bias"], atol=1e-6)
    np.testing.assert_allclose(marker["R"].T @ marker["R"], np.eye(3), atol=MACHINE)
    return marker
