"""A body without geometric stiffness says so where its loads would change its stiffness.

Reference: Euler's column, pi^2 EI / (4 L^2); the rotating cantilever, whose lowest frequency in flapping rises from
3.516 to 3.681 at a speed of 1 (in units of sqrt(EI / mu) / L^2; Wright et al. 1982), so by 9.6 % in its square.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb import fem, reduction

STEEL = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
L, D = 1.0, 0.01
EI, MU = 210e9 * np.pi * D**4 / 64, 7850.0 * np.pi * D**2 / 4


def rod(geometric_stiffness=False, **more):
    points = np.column_stack([np.linspace(0.0, L, 13), np.zeros((13, 2))])
    sets = {"a": [0], "b": [12]}
    fe = fem.frame(points, section=fem.Section.solid_circle(D), material=STEEL, node_sets=sets)
    more = {"loads": {"push": {6: (0.0, 1.0, 0.0)}}, "geometric_stiffness": geometric_stiffness, **more}
    return reduction.reduce(fe, {"a": "a", "b": "b"}, 4, **more)


def block():
    """A stocky solid, 40 mm thick and 100 mm long."""
    x, y = np.linspace(0.0, 0.1, 6), np.linspace(0.0, 0.04, 3)
    grid = np.stack(np.meshgrid(x, y, y, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(54).reshape(6, 3, 3)
    grid -= (0.0, 0.02, 0.02)  # the interfaces are on the x-axis
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = np.stack([number[i : i + 5, j : j + 2, k : k + 2].ravel() for i, j, k in corners], axis=1)
    mesh = fem.Mesh(
        points=grid, cells=(("hexahedron", cells),), node_sets={"a": number[0].ravel(), "b": number[-1].ravel()}
    )
    return reduction.reduce(fem.solid(mesh, STEEL), {"a": "a", "b": "b"}, 4)


def column(data, force, across=0.0):
    """Return the equilibrium of a body that is held at one end and pressed along its axis at the other."""
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("b", data=data)],
        joints=[fmb.Fixed("hold", markers=("ground.origin", "b.a"))],
        forces=[fmb.PointLoad("press", marker="b.b", force=(-force, across, 0.0))],
    )
    return fmb.statics(model)


def spinning(data, speed, **place):
    """Return a twentieth of a turn of a blade that is driven at a constant speed."""
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("b", data=data, angular_velocity=(0, 0, speed), **place)],
        joints=[
            fmb.Revolute("hub", markers=("ground.origin", "b.a")),
            fmb.Drive("spin", joint="hub", angle=fmb.ramp(rate=speed)),
        ],
    )
    return fmb.simulate(model, 0.05 * 2.0 * np.pi / speed, samples=11)


def share(solution):
    (known,) = solution.statistics["share of validity"].values()
    return known["left out"]


@pytest.mark.parametrize("part", [0.05, 0.3, 2.0])
@pytest.mark.parametrize("frame", ["buckens", "a"])
def test_a_column_near_its_buckling_load_is_told(part, frame, recwarn):
    """Told: the change of stiffness, for a body of either frame; below 10 % nothing."""
    solution = column(rod(frame=frame), part * np.pi**2 * EI / (4.0 * L**2))
    told = [str(w.message) for w in recwarn if "its reduction leaves out" in str(w.message)]
    assert len(told) == (part > 0.1)
    assert 0.8 * part < 0.1 * share(solution) < 2.0 * part
    if told:
        assert told[0].startswith("Body 'b' carries loads that change its stiffness by up to")
        assert "most of it by interface '" in told[0]
        assert "in equilibrium" in told[0]
        assert "geometric_stiffness=True" in told[0]


def test_a_blade_that_spins_is_told(recwarn):
    """The pull of the hub and the spin of the blade are added in size: told is up to three times the change."""
    unit = np.sqrt(EI / MU) / L**2
    data = rod()
    for speed, told in ((0.5, False), (3.0, True)):
        change = (3.681**2 / 3.516**2 - 1.0) * speed**2
        assert change < 0.1 * share(spinning(data, speed * unit)) < 3.0 * change
        assert any("its reduction leaves out" in str(w.message) for w in recwarn) == told


def test_with_geometric_stiffness_nothing_is_left_out(recwarn):
    data = rod(geometric_stiffness=True)
    assert data.left_out == {}
    column(data, 0.5 * np.pi**2 * EI / (4.0 * L**2))
    assert not [w for w in recwarn if "leaves out" in str(w.message)]


def test_a_stocky_body_carries_its_load(recwarn):
    """100 MPa in a block: Euler's load is seventy times as large."""
    solution = column(block(), 1e8 * 0.04**2)
    part = 1e8 / (np.pi**2 * 210e9 * (0.04**2 / 12.0) / (4.0 * 0.1**2))
    assert 0.8 * part < 0.1 * share(solution) < 2.0 * part
    assert not [w for w in recwarn if "leaves out" in str(w.message)]


def test_other_units_and_axes():
    """In millimetres and tonnes, and in axes turned and moved: the same share."""
    data = rod()
    load = 0.5 * np.pi**2 * EI / (4.0 * L**2)
    with pytest.warns(fmb.ValidityWarning, match="its reduction leaves out"):
        expected = share(column(data, load))
    scaled = reduction.rescaled(data, length=1e3, mass=1e-3)
    with pytest.warns(fmb.ValidityWarning, match="its reduction leaves out"):
        assert share(column(scaled, load)) == pytest.approx(expected, rel=1e-6)

    turn, origin = Rotation.from_rotvec((0.3, 0.2, -0.4)), (0.2, -0.5, 0.1)
    moved = reduction.moved(data, rotation=turn, origin=origin)
    assert moved.left_out["loads"] == data.left_out["loads"] != {}
    back = turn.inv().as_matrix()
    place = {"at": origin, "rotation": turn, "markers": {"a": fmb.Pose.axes(x=back[:, 0], z=back[:, 2])}}
    speed = 3.0 * np.sqrt(EI / MU) / L**2
    place["velocity"] = np.cross((0.0, 0.0, speed), origin)
    with pytest.warns(fmb.ValidityWarning, match="its reduction leaves out"):
        assert share(spinning(moved, speed, **place)) == pytest.approx(share(spinning(data, speed)), rel=1e-5)
