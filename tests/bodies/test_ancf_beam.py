"""The beam with directors against differences, rigid motions, and what its energy says."""

import numpy as np
import pytest
from bodies.ancf_states import BENT, SOFT, disturbed
from contracts.random_models import derivative, moved
from tolerances import MACHINE, SOLVER

import flexmb as fmb
from flexmb import fem
from flexmb.errors import ModelError
from flexmb.integrate.matrices import tangent_at
from flexmb.math.rotations import rotation_matrix
from flexmb.system.program import energies, evaluate

H = 1e-3
SECTION = fem.Section.rectangle(0.1, 0.2)


def beam(**fields) -> fmb.AncfBeam:
    """A soft, damped, curved beam of two elements with a marker inside the second."""
    return fmb.AncfBeam("b", **{
        "points": BENT, "elements": 2, "section": SECTION, "material": SOFT, "damping": 0.02, "initial_strain": 0.03,
        "orientation": (0, 0.3, 1), "markers": {"m": (0.7, (0.3, -0.2, 0.5))}, **fields})


def loaded(**fields):
    load = fmb.PointLoad("f", marker="b.m", force=(3.0, -1.0, 2.0), moment=(0.8, 0.5, -0.6))
    return fmb.Model(bodies=(fmb.Ground(), beam(**fields)), forces=(load,), gravity=(1.0, -2.0, -9.0))


def residual(system, state, work):
    work.coefficients[3] = 0.0
    evaluate(system.program, state, work)
    return work.residual.copy()


@pytest.mark.parametrize("fields", [{}, {"damping": 0.0, "straight": True}], ids=["damped", "straight without load"])
def test_tangent_is_the_derivative(fields, rng):
    system, state = disturbed(loaded(**fields), rng)
    work = system.workspace()
    tangent = tangent_at(system, state, work)
    changes = {
        "M": lambda x, d: state._replace(a=state.a + x * d),
        "D": lambda x, d: state._replace(u=state.u + x * d),
        "K": lambda x, d: moved(system, state, d, x),
    }
    for name, change in changes.items():
        expected = np.array([derivative(lambda x, d=d, c=change: residual(system, c(x, d), work), H)
                             for d in np.eye(system.nu)]).T
        found = getattr(tangent, name).toarray()
        np.testing.assert_allclose(found, expected, atol=1e-8 * max(1.0, np.abs(expected).max()), err_msg=name)


def test_power_changes_the_energy(rng):
    """u . (M a + h) = d(T + U + V)/dt + dissipated power, without loads."""
    model = fmb.Model(bodies=(fmb.Ground(), beam()), gravity=(1.0, -2.0, -9.0))
    system, state = disturbed(model, rng)
    work = system.workspace()

    def energy(x):
        later = moved(system, state, state.u * x + 0.5 * state.a * x * x, 1.0, u=state.u + x * state.a)
        energies(system.program, later, work)
        return work.energy[:3].sum()

    change = derivative(energy, H)
    power = state.u @ residual(system, state, work)
    assert power == pytest.approx(change + work.energy[5], rel=1e-8)
    assert work.energy[5] > 0.0


def test_marker_moves_as_its_jacobian_says(rng):
    system, state = disturbed(loaded(), rng)
    work = system.workspace()
    number = system.marker_index["b.m"]

    def pose(x):
        later = moved(system, state, state.u * x + 0.5 * state.a * x * x, 1.0, u=state.u + x * state.a)
        residual(system, later, work)
        marker = work.markers[number]
        return np.concatenate([marker["r"], marker["R"].ravel(), marker["v"], marker["w"]])

    rate = derivative(pose, H)
    residual(system, state, work)
    marker = work.markers[number].copy()
    J = work.J[marker["iJ"] : marker["iJ"] + 6 * marker["nu"]].reshape(6, -1)
    u, a = (x[marker["iu"] : marker["iu"] + marker["nu"]] for x in (state.u, state.a))
    assert marker["nu"] == 27
    np.testing.assert_allclose(J @ u, np.concatenate([marker["v"], marker["w"]]), atol=1e2 * MACHINE)
    np.testing.assert_allclose(rate[:3], marker["v"], atol=1e-8)
    spin = rate[3:12].reshape(3, 3) @ marker["R"].T
    np.testing.assert_allclose([spin[2, 1], spin[0, 2], spin[1, 0]], marker["w"], atol=1e-7)
    np.testing.assert_allclose(rate[12:], J @ a + marker["bias"], atol=1e-6)


def test_rigid_motion_makes_no_force_and_no_damping(rng):
    R = rotation_matrix((1.0, 2.0, -2.5))
    body = beam(initial_strain=0.0, at=(3, 2, 1), rotation=R, velocity=(1, 2, 3), angular_velocity=(4, -5, 6))
    system, _ = disturbed(fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0)), rng, 0.0)
    work = system.workspace()
    # directors between nodes of a curved line are a little shorter than one: only the walls at the nodes are unstrained
    np.testing.assert_allclose(residual(system, system.state(), work), 0.0, atol=1e-9 * SOFT.young * SECTION.area)
    assert abs(work.energy[5]) < 1e-12
    energies(system.program, system.state(), work)
    assert work.energy[1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("slenderness", [4, 40, 1000])
def test_no_locking(slenderness):
    """Tip deflection of four elements under a small load, thick and thin: P L^3/3EI + P L/GA_s, to 1 %."""
    L, young = 2.0, 1e9
    h = L / slenderness
    section = fem.Section.rectangle(h, h)
    body = fmb.AncfBeam("b", points=((0, 0, 0), (L, 0, 0)), elements=4, section=section,
                        material=fmb.Material(young=young, poisson=0.3, density=1e3))
    EI, GA = young * section.inertia_y, body.material.shear * section.area * section.shear_z
    load = 0.05 * EI / L**2
    solution = fmb.statics(fmb.Model(
        bodies=(fmb.Ground(), body), gravity=(0, 0, 0),
        joints=(fmb.Fixed("clamp", markers=("ground.origin", "b.start")),),
        forces=(fmb.PointLoad("P", marker="b.end", force=(0, 0, load)),)), tolerance=1e-6)
    deflection = body.line(solution.final.q, 1.0)[5][0, 2]
    assert deflection == pytest.approx(load * (L**3 / (3 * EI) + L / GA), rel=0.01)


def test_patch_of_unequal_lines():
    """Pure tension, torsion and bending are exact with any number of elements: constant section forces."""
    body = beam(points=((0, 0, 0), (2, 0, 0)), orientation=None, initial_strain=0.0, elements=3, damping=0.0)
    twist = 0.05 * body.material.shear * SECTION.torsion
    solution = fmb.statics(fmb.Model(
        bodies=(fmb.Ground(), body), gravity=(0, 0, 0),
        joints=(fmb.Fixed("clamp", markers=("ground.origin", "b.start")),),
        forces=(fmb.PointLoad("T", marker="b.end", force=(0.4, 0, 0), moment=(twist, 0, 0)),)))
    forces = body.section_forces(solution.final.q, [0.0, 0.3, 1.0])
    expected = [0.4, 0, 0, twist, 0, 0]
    np.testing.assert_allclose(forces, np.tile(expected, (3, 1)), atol=SOLVER)


REFUSED = {
    "orientation": ({"orientation": (0.4, 0.2, 0.1), "points": ((0, 0, 0), (0.8, 0.4, 0.2))}, "orientation ="),
    "rotary inertia": ({"rotary_inertia": (1.0, 0.0)}, "rotary_inertia ="),
    "damping": ({"damping": -1.0}, "damping = -1.0"),
    "section": ({"section": fem.Section.values(1.0, 1.0, 1.0, 1.0, area_center=(0.1, 0.0))}, "centres off the line"),
}


@pytest.mark.parametrize(("fields", "found"), REFUSED.values(), ids=REFUSED)
def test_refused(fields, found):
    with pytest.raises(ModelError, match="Body 'b'") as error:
        beam(**fields)
    assert found in str(error.value)
