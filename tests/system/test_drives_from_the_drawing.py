"""A drive is no way from the drawing: one that begins where the mechanism cannot be is named with its distance."""

import numpy as np
import pytest

import flexmb as fmb

CRANK, ROD = 0.1, 0.3
ACROSS, ALONG = fmb.Pose.axes(z=(0, 1, 0)), fmb.Pose.axes(z=(1, 0, 0))


def slider_crank(displacement, angle=0.5) -> fmb.Model:
    """A crank at an angle, whose slider is drawn at x = CRANK cos + ROD cos of the rod, and driven."""
    pin = CRANK * np.array([np.cos(angle), np.sin(angle)])
    lean = np.arcsin(pin[1] / ROD)
    rods = {
        "crank": {"length": CRANK, "rotation": (0, -angle, 0)},
        "rod": {"length": ROD, "rotation": (0, lean, 0), "at": (pin[0], 0, pin[1])},
    }
    bodies = [
        fmb.RigidBody.rod(
            name,
            mass=1.0,
            radius=0.005,
            markers={"A": ACROSS, "B": fmb.Pose.axes((given["length"], 0, 0), z=(0, 1, 0))},
            **given,
        )
        for name, given in rods.items()
    ]
    at = (pin[0] + ROD * np.cos(lean), 0.0, 0.0)
    piston = fmb.RigidBody("piston", mass=2.0, inertia=(1e-3,) * 3, at=at, markers={"C": ACROSS, "s": ALONG})
    return fmb.Model(
        bodies=[fmb.Ground(markers={"A": ACROSS, "s": ALONG}), *bodies, piston],
        joints=[
            fmb.Revolute("A", markers=("ground.A", "crank.A")),
            fmb.Revolute("B", markers=("crank.B", "rod.A")),
            fmb.Spherical("C", markers=("rod.B", "piston.C")),
            fmb.Prismatic("s", markers=("ground.s", "piston.s")),
            fmb.Drive("push", joint="s", displacement=displacement),
        ],
        sensors=[fmb.Position("x", marker="piston.center")],
    )


def test_a_drive_that_begins_elsewhere_is_named():
    """The slider is drawn 0.384 m from the crank, and the mechanism reaches from 0.2 to 0.4 m."""
    with pytest.raises(
        fmb.CompileError, match=r"Joint 'push' begins at t = 0 s 0\.384 m away .*not a way from the drawing"
    ):
        fmb.simulate(slider_crank(fmb.expression("-0.05*t")), 0.1)


def test_with_the_drawn_coordinate_added_it_runs():
    x = CRANK * np.cos(0.5) + np.sqrt(ROD**2 - (CRANK * np.sin(0.5)) ** 2)
    solution = fmb.simulate(slider_crank(fmb.expression("x - 0.05*t", x=x)), 0.1, samples=3)
    assert solution["x"][:, 0] == pytest.approx(x - 0.05 * solution.t, abs=1e-9)


def test_a_drive_near_its_drawing_is_not_blamed():
    """Two parts that cannot meet, with a drive that fits."""
    model = slider_crank(fmb.expression("0.384"))
    rigid = fmb.Rod("strut", markers=("crank.B", "ground.A"), length=0.25)
    with pytest.raises(fmb.CompileError) as told:
        fmb.simulate(model.with_parts(joints=[rigid]), 0.1)
    assert "begins at" not in str(told.value)


@pytest.mark.parametrize(("drawn", "told"), [(0.8, True), (0.05, False)])
def test_check_notes_that_a_drive_has_moved_the_drawing(drawn, told):
    rod = fmb.RigidBody.rod("rod", length=1.0, mass=1.0, rotation=(0, drawn, 0), markers={"A": ACROSS})
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"A": ACROSS}), rod],
        joints=[
            fmb.Revolute("A", markers=("ground.A", "rod.A")),
            fmb.Drive("turn", joint="A", angle=fmb.expression("2*t")),
        ],
    )
    found = [note for note in fmb.check(model).notes if "Joint 'turn' begins at t = 0 s 0.8 rad away" in note]
    assert len(found) == told
