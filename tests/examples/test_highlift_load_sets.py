"""Load sets of the high-lift example, its airload as load shapes, and the parameter of geometric stiffness.

Reference: forces in proportion to the airload of a slow extension, the form of the gust by hand, and the tables of
the data set.
"""

import numpy as np
import pytest
from highlift_runs import DATA, FOLDER, run

import flexmb as fmb

SLOW = ("duration", 20.0)


def drives(*settings):
    """Return the times and the sum of the torques on the levers of the droop nose, an extension in 20 s."""
    solution = run("droop_operation", SLOW, *settings, samples=201)
    return solution.t, solution["drive 2 torque"][:, 5] + solution["drive 4 torque"][:, 5]


def test_gust():
    """A gust of 1.5 makes the torque half as large again in its middle, by sin^2 before and after,
    and leaves no trace.
    """
    gust = (("load_set", 2), ("gust_start", 9.0), ("gust_duration", 6.0))
    t, one = drives()
    _, two = drives(*gust)
    phase = np.clip((t - 9.0) / 6.0, 0.0, 1.0)
    np.testing.assert_allclose(two / one, 1.0 + 0.5 * np.sin(np.pi * phase) ** 2, rtol=0.01)


@pytest.mark.slow
def test_jam():
    """Twice the load: twice the torque, on both edges of the wing; the same as the factor by hand."""
    _, one = drives()
    _, two = drives(("load_set", 3))
    np.testing.assert_allclose(two / one, DATA["airloads"]["limit_load_factor"], rtol=0.02)
    by_set, by_hand = (
        run("operation", setting, t_end=0.3, samples=31) for setting in (("load_set", 3), ("load_factor", 2.0))
    )
    for name in ("inboard_t2_strut force", "outboard_t4_strut force"):
        np.testing.assert_array_equal(by_set[name], by_hand[name])


@pytest.mark.parametrize("side", ["inboard", "outboard"])
def test_load_shapes_carry_the_airload(side):
    """Resultant and moment about the span of the three load shapes, over the angle of the lever:
    those of the nose points.
    """
    model = fmb.load_model(FOLDER / f"{side}.toml", {"rigid": False})
    body = model.body("flap_beam")
    assert body.geometric_stiffness is True
    loads = [force for force in model.forces if isinstance(force, fmb.Pressure)]
    assert len(loads) == 3
    assert not any(isinstance(force, fmb.PointLoad) for force in model.forces)
    air, table = DATA["airloads"], DATA["airloads"][side]
    total = np.zeros(6)
    for force in loads:
        gust, curve = next(term for term in force.amount.terms if hasattr(term, "terms")).terms
        factor = next(term for term in force.amount.terms if not hasattr(term, "terms"))
        assert gust.sample(0.0)[0] == 1.0
        assert factor.sample(0.0)[0] == air["dynamic_pressure"]
        shape = body.data.load_shapes[body.data.load_names.index(force.load.partition(".")[2])]
        total += air["dynamic_pressure"] * curve.y[5] * shape[:6]
    points = np.array(DATA["trailing_edge"][f"{side}_flap"]["nose_points_y" if side == "inboard" else "nose_points_Y"])
    flap = DATA["trailing_edge"][f"{side}_flap"]
    start, end = flap["y_range"] if side == "inboard" else (0.0, flap["span"])
    c = np.interp(points, [start, end], flap["chord"])
    strips = (end - start) / len(points) * c * np.array(table.get("spanwise_factor", np.ones(len(points))))
    CN, CC, XCP = (table[key][5] for key in ("CN", "CC", "XCP"))
    q = air["dynamic_pressure"]
    np.testing.assert_allclose(total[:3], [q * CC * strips.sum(), 0.0, q * CN * strips.sum()], rtol=1e-9, atol=1e-6)
    assert total[4] == pytest.approx(-q * CN * XCP * np.sum(strips * c), rel=1e-9)


@pytest.mark.slow
def test_geometric_stiffness_is_one_parameter():
    """It reaches all elastic bodies; the forces in them are far from those that buckle them, so it changes little."""
    angles = []
    for value in (True, False):
        bodies = [
            body
            for case in ("operation", "droop_operation")
            for body in fmb.load_model(FOLDER / f"{case}.toml", {"rigid": False, "geometric_stiffness": value}).bodies
            if body.has_frame and body.n_vector
        ]
        assert len(bodies) == 12
        assert all(bool(body.geometric_stiffness) is value for body in bodies)
        model = fmb.load_model(
            FOLDER / "droop_nose.toml", {"rigid": False, "geometric_stiffness": value, "load_set": 3}
        )
        angles.append(fmb.statics(model)["s2_nose angle"][-1])
    assert 0.0 < abs(angles[1] / angles[0] - 1.0) < 1e-2
