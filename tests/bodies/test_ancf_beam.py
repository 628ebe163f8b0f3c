"""The beam with directors against differences, rigid motions, and what its energy says."""

import numpy as np
import pytest
from bodies.ancf_states import (
    BENT,
    SOFT,
    assert_marker_moves_as_its_jacobian_says,
    assert_tangent_is_the_derivative,
    dissipation_beside_the_energy,
    disturbed,
    residual,
)
from tolerances import SOLVER

import flexmb as fmb
from flexmb import fem
from flexmb.errors import ModelError
from flexmb.math.rotations import rotation_matrix
from flexmb.system.program import energies

SECTION = fem.Section.rectangle(0.1, 0.2)


def beam(**fields) -> fmb.AncfBeam:
    """A soft, damped, curved beam of two elements with a marker inside the second."""
    return fmb.AncfBeam(
        "b",
        **{
            "points": BENT,
            "elements": 2,
            "section": SECTION,
            "material": SOFT,
            "damping": 0.02,
            "initial_strain": 0.03,
            "orientation": (0, 0.3, 1),
            "markers": {"m": (0.7, (0.3, -0.2, 0.5))},
            **fields,
        },
    )


def loaded(**fields):
    load = fmb.PointLoad("f", marker="b.m", force=(3.0, -1.0, 2.0), moment=(0.8, 0.5, -0.6))
    return fmb.Model(bodies=(fmb.Ground(), beam(**fields)), forces=(load,), gravity=(1.0, -2.0, -9.0))


@pytest.mark.parametrize("fields", [{}, {"damping": 0.0, "straight": True}], ids=["damped", "straight without load"])
def test_tangent_is_the_derivative(fields, rng):
    assert_tangent_is_the_derivative(*disturbed(loaded(**fields), rng))


def test_power_changes_the_energy(rng):
    """u . (M a + h) = d(T + U + V)/dt + dissipated power, without loads."""
    assert dissipation_beside_the_energy(beam(), rng) > 0.0


def test_marker_moves_as_its_jacobian_says(rng):
    marker = assert_marker_moves_as_its_jacobian_says(*disturbed(loaded(), rng), "b.m")
    assert marker["nu"] == 27


def test_rigid_motion_makes_no_force_and_no_damping(rng):
    R = rotation_matrix((1.0, 2.0, -2.5))
    body = beam(initial_strain=0.0, at=(3, 2, 1), rotation=R, velocity=(1, 2, 3), angular_velocity=(4, -5, 6))
    system, _ = disturbed(fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0)), rng, 0.0)
    work = system.workspace()
    # directors between nodes of a curved line are a little shorter than one: only the walls at the nodes are unstrained
    np.testing.assert_allclose(residual(system, system.state(), work), 0.0, atol=1e-9 * SOFT.young * SECTION.area)
    assert abs(work.energy[0].dissipation) < 1e-12
    energies(system.program, system.state(), work)
    assert work.energy[0].strain == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("slenderness", [4, 40, 1000])
def test_no_locking(slenderness):
    """Tip deflection of four elements under a small load, thick and thin: P L^3/3EI + P L/GA_s, to 1 %."""
    L, young = 2.0, 1e9
    h = L / slenderness
    section = fem.Section.rectangle(h, h)
    body = fmb.AncfBeam(
        "b",
        points=((0, 0, 0), (L, 0, 0)),
        elements=4,
        section=section,
        material=fmb.Material(young=young, poisson=0.3, density=1e3),
    )
    EI, GA = young * section.inertia_y, body.material.shear * section.area * section.shear_z
    load = 0.05 * EI / L**2
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(), body),
            gravity=(0, 0, 0),
            joints=(fmb.Fixed("clamp", markers=("ground.origin", "b.start")),),
            forces=(fmb.PointLoad("P", marker="b.end", force=(0, 0, load)),),
        ),
        tolerance=1e-6,
    )
    deflection = body.line(solution.final.q, 1.0)[5][0, 2]
    assert deflection == pytest.approx(load * (L**3 / (3 * EI) + L / GA), rel=0.01)


def test_patch_of_unequal_lines():
    """Pure tension, torsion and bending are exact with any number of elements: constant section forces."""
    body = beam(points=((0, 0, 0), (2, 0, 0)), orientation=None, initial_strain=0.0, elements=3, damping=0.0)
    twist = 0.05 * body.material.shear * SECTION.torsion
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(), body),
            gravity=(0, 0, 0),
            joints=(fmb.Fixed("clamp", markers=("ground.origin", "b.start")),),
            forces=(fmb.PointLoad("T", marker="b.end", force=(0.4, 0, 0), moment=(twist, 0, 0)),),
        )
    )
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
