"""Every joule is accounted for: bodies and forces change the energies by the work they say they do."""

from dataclasses import replace

import numpy as np
import pytest
from by_turns import every_second
from contracts.random_models import FORCES, PAIRS, connected, derivative, moved, random_state, single

from flexmb import bodies
from flexmb.math.energies import stored_energies
from flexmb.system.program import energies, evaluate

H = 1e-2
FINE = 2e-3  # the laws of contacts are less smooth than motions
DIFFERENCE = 1e-8
BODIES = [name for name, kind in bodies.KINDS.items() if kind.table is not None]


def energy_along(system, state, work):
    """Return the stored energies (3,) as a function of x along the motion q [+] (u x + a x^2 / 2), u + a x."""

    def at(x):
        later = moved(system, state, state.u * x + 0.5 * state.a * x * x, 1.0, t=state.t + x, u=state.u + x * state.a)
        energies(system.program, later, work)
        return stored_energies(work.energy)

    return at


@pytest.mark.parametrize("kind", BODIES)
def test_power_of_inertia_gravity_and_elasticity(kind, rng):
    """u . (M a + h - f) = d(T + U + V)/dt + dissipation: the power that the residual lacks changes the energy."""
    model = single(kind, rng)
    if kind == "FloatingBody":
        # The linear strain energy does not know the geometric stiffness; and with the consistent mass matrix of a frame
        # the weight of the deformed body acts at a point that differs from its centre of mass by the rotation shapes.
        model = replace(model.changed("b", geometric_stiffness=False), gravity=(0.0, 0.0, 0.0))
    system, state = random_state(model, rng)
    work = system.workspace()
    change = derivative(energy_along(system, state, work), H)[:3].sum()
    evaluate(system.program, state, work)
    power = state.u @ work.residual
    assert power == pytest.approx(change + work.energy[0].dissipation, rel=DIFFERENCE, abs=DIFFERENCE)


@pytest.mark.parametrize(("pair", "kind"), every_second(PAIRS, FORCES))
def test_power_of_a_force(kind, pair, rng):
    """Wrenches times twists = work of loads - dissipation - rate of the potential."""
    model = connected(kind, pair, rng)
    model = type(model)(bodies=model.bodies, surfaces=model.surfaces, joints=model.joints, forces=model.forces)
    system, state = random_state(model, rng)
    state = state._replace(lam=np.zeros(system.ng))
    work = system.workspace()
    evaluate(system.program, state, work)
    for _, rates in system.state_slices.values():  # states change as their law says
        state.a[rates] -= work.residual[rates]
    still = type(model)(bodies=model.bodies)
    bare = random_state(still, rng)[0]
    alone = bare.state(state.t, state.q[: bare.nq], state.u[: bare.nu], state.a[: bare.nu])
    potential = derivative(energy_along(system, state, work), FINE)[2]
    potential -= derivative(energy_along(bare, alone, bare.workspace()), FINE)[2]
    evaluate(system.program, state, work)
    m = work.markers[: len(system.marker_index)]  # those of states follow
    power = np.sum(m["wrench"][:, :3] * m["v"]) + np.sum(m["wrench"][:, 3:] * m["w"])
    dissipated = work.energy[0].dissipation
    evaluate(bare.program, alone, other := bare.workspace())
    dissipated -= other.energy[0].dissipation
    assert power == pytest.approx(work.energy[0].load_power - dissipated - potential, rel=DIFFERENCE, abs=DIFFERENCE)
