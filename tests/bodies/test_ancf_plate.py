"""The plates against differences, rigid motions, and what their energy says."""

import numpy as np
import pytest
from bodies.ancf_states import (
    SOFT,
    assert_marker_moves_as_its_jacobian_says,
    assert_tangent_is_the_derivative,
    dissipation_beside_the_energy,
    disturbed,
    residual,
)
from tolerances import MACHINE

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.math.rotations import rotation_matrix
from flexmb.system.program import energies

CURVED = [[(x, y, 0.2 * x * x + 0.1 * x * y) for y in (0.0, 0.5, 1.1)] for x in (0.0, 0.6, 1.3)]
KINDS = pytest.mark.parametrize("shear", [False, True], ids=["thin", "shear"])


def plate(**fields) -> fmb.AncfPlate:
    """A soft, damped, curved and tapered plate of two by two elements with a marker inside one and one of an edge."""
    return fmb.AncfPlate(
        "b",
        **{
            "points": CURVED,
            "thickness": [[0.1, 0.12], [0.08, 0.05]],
            "material": SOFT,
            "damping": 0.02,
            "initial_strain": 0.03,
            "markers": {"m": ((0.7, 0.3), (0.3, -0.2, 0.5)), "edge": (1.0, "mean")},
            **fields,
        },
    )


def loaded(**fields):
    """The plate with forces and moments on a point and an edge, pressure and a dead load."""
    forces = (
        fmb.PointLoad("f", marker="b.m", force=(3.0, -1.0, 2.0), moment=(0.8, 0.5, -0.6)),
        fmb.PointLoad("e", marker="b.edge", force=(1.0, 0.0, 2.0), moment=(0.3, -0.5, 0.6)),
        fmb.Pressure("p", load="b.pressure", amount=7.0),
        fmb.Pressure("y", load="b.load_y", amount=3.0),
    )
    return fmb.Model(bodies=(fmb.Ground(), plate(**fields)), forces=forces, gravity=(1.0, -2.0, -9.0))


@KINDS
@pytest.mark.parametrize("fields", [{}, {"damping": 0.0, "flat": True}], ids=["damped", "flat without load"])
def test_tangent_is_the_derivative(fields, shear, rng):
    assert_tangent_is_the_derivative(*disturbed(loaded(shear=shear, **fields), rng))


@KINDS
def test_power_changes_the_energy(shear, rng):
    """u . (M a + h) = d(T + U + V)/dt + dissipated power, without loads."""
    assert dissipation_beside_the_energy(plate(shear=shear), rng) > 0.0


@KINDS
@pytest.mark.parametrize("marker", ["m", "edge", "corner_11"])
def test_marker_moves_as_its_jacobian_says(marker, shear, rng):
    assert_marker_moves_as_its_jacobian_says(*disturbed(loaded(shear=shear), rng), f"b.{marker}")


@KINDS
def test_rigid_motion_makes_no_force_and_no_damping(shear, rng):
    R = rotation_matrix((1.0, 2.0, -2.5))
    body = plate(
        shear=shear, initial_strain=0.0, at=(3, 2, 1), rotation=R, velocity=(1, 2, 3), angular_velocity=(4, -5, 6)
    )
    system, _ = disturbed(fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0)), rng, 0.0)
    work = system.workspace()
    np.testing.assert_allclose(residual(system, system.state(), work), 0.0, atol=MACHINE * SOFT.young)
    assert abs(work.energy[0].dissipation) < MACHINE * SOFT.young
    energies(system.program, system.state(), work)
    assert work.energy[0].strain == pytest.approx(0.0, abs=1e-12)


@KINDS
def test_mass_and_momentum(shear, rng):
    """The kinetic energy, the momenta and the mass of a rotating plate are those of the body it is drawn as."""
    w = np.array((0.3, -0.5, 2.0))
    body = fmb.AncfPlate.rectangle(
        "b",
        edges=(2.0, 1.0),
        elements=(3, 2),
        thickness=0.3,
        material=SOFT,
        shear=shear,
        corner=(-1.0, -0.5, 0.0),
        at=(1, 2, 3),
        velocity=(1, -2, 0.5),
        angular_velocity=w,
    )
    system, _ = disturbed(fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0)), rng, 0.0)
    work, start = system.workspace(), system.state()
    energies(system.program, start, work)
    m = SOFT.density * 2.0 * 1.0 * 0.3
    through = 0.3**2 if shear else 0.0
    J = m / 12.0 * np.array([1.0 + through, 4.0 + through, 5.0])
    v = np.array(body.velocity)
    assert body.mass == pytest.approx(m, rel=1e-12)
    # a director of constant length has no inertia about itself: that of a thin plate about its normal
    assert work.energy[0].kinetic == pytest.approx(0.5 * m * v @ v + 0.5 * w @ (J * w), rel=1e-12)
    total = np.concatenate([m * v, np.cross(body.at, m * v) + J * w])
    np.testing.assert_allclose(body.momentum(start.q[None], start.u[None])[0], total, rtol=1e-12)


REFUSED = {
    "points": ({"points": ((0, 0, 0), (1, 0, 0))}, "points of shape (2, 3)"),
    "elements": ({"elements": (2, 0)}, "elements = (2, 0)"),
    "no thickness": ({"thickness": 0.0}, "thickness = 0.0"),
    "negative taper": ({"thickness": [[0.1, -0.1], [0.1, 0.1]]}, "thickness = [[0.1, -0.1]"),
    "material": ({"material": 210e9}, "material = 210000000000.0"),
    "damping": ({"damping": -1.0}, "damping = -1.0"),
    "initial strain": ({"initial_strain": 1.5}, "initial_strain = 1.5"),
    "shear factor": ({"shear_factor": 0.0}, "shear_factor = 0.0"),
    "marker": ({"markers": {"m": (0.5, 1.5)}}, "marker m at (0.5, 1.5)"),
    "two means": ({"markers": {"m": ("mean", "mean")}}, "marker m at ('mean', 'mean')"),
    "no area": ({"points": [[(0, 0, 0), (1, 0, 0)], [(2, 0, 0), (3, 0, 0)]]}, "element (0, 0) without area"),
    "folded": ({"points": [[(0, 0, 0), (0, 1, 0)], [(1, 0, 0), (0.2, 0.2, 0)]]}, "element (0, 0) is folded"),
    "warped": ({"points": [[(0, 0, 0), (0, 1, 2)], [(1, 0, 2), (1, 1, 0)]]}, "element (0, 0) is warped"),
    "no tangent": ({"points": [[(0, 0, 0), (0, 0, 0)], [(1, 0, 0), (1, 1, 0)]]}, "no tangent along t"),
}


@pytest.mark.parametrize(("fields", "found"), REFUSED.values(), ids=REFUSED)
def test_refused(fields, found):
    with pytest.raises(ModelError, match="Body 'b'") as error:
        plate(**fields)
    assert found in str(error.value)


def test_unknown_edge_and_load():
    with pytest.raises(ModelError, match="edge 'left'"):
        plate().held("root", "left", fmb.Fixed)
    with pytest.raises(ModelError, match="body 'b' has no load 'presure'"):
        fmb.Model(bodies=(fmb.Ground(), plate()), forces=(fmb.Pressure("p", load="b.presure", amount=1.0),))
    over_joint = fmb.table([0, 1], [0, 1], of="hinge")
    with pytest.raises(ModelError, match="an amount over joint 'hinge' on body 'b'"):
        fmb.Model(
            bodies=(fmb.Ground(), plate()),
            forces=(fmb.Pressure("p", load="b.pressure", amount=over_joint),),
            joints=(fmb.Revolute("hinge", markers=("ground.origin", "b.m")),),
        )
