"""A body without geometric stiffness says so where its loads would change its stiffness.

Reference: Euler's column, pi^2 EI / (4 L^2); the rotating cantilever, whose lowest frequency in flapping rises from
3.516 to 3.681 at a speed of 1 (in units of sqrt(EI / mu) / L^2; Wright et al. 1982), so by 9.6 % in its square.
"""

from dataclasses import replace

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


def strut(data, force, foot=fmb.Spherical):
    """Return the equilibrium of a body between a foot and a ball in a guide along its axis, pressed together."""
    guide = fmb.Pose.axes(at=(L, 0, 0), z=(1, 0, 0), x=(0, 1, 0))
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"guide": guide}), fmb.FloatingBody("b", data=data)],
        joints=[foot("A", markers=("ground.origin", "b.a")), fmb.InLine("B", markers=("ground.guide", "b.b"))],
        forces=[fmb.PointLoad("press", marker="b.b", force=(-force, 0.0, 0.0))],
    )
    return fmb.statics(model)


def brought_up(data, speed):
    """Return a blade that is brought to a speed without stretching it suddenly."""
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("b", data=data)],
        joints=[
            fmb.Revolute("hub", markers=("ground.origin", "b.a")),
            fmb.Drive("spin", joint="hub", angle=fmb.ramp(rate=speed, rise=2.0)),
        ],
    )
    return fmb.simulate(model, 2.2, samples=12)


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
    assert 0.1 * share(solution) == pytest.approx(part, rel=1e-4)
    if told:
        assert told[0].startswith("Body 'b' carries loads that change its stiffness by up to")
        assert "most of it by interface '" in told[0]
        assert "in equilibrium" in told[0]
        assert "geometric_stiffness=True" in told[0]


@pytest.mark.parametrize("frame", ["buckens", "a"])
def test_a_strut_between_pins_carries_four_times_as_much(frame, recwarn):
    """Euler's load between pins, pi^2 EI / L^2: a twelfth of it is no cause for a warning, an eighth is."""
    data, euler = rod(frame=frame), np.pi**2 * EI / L**2
    for part, told in ((1.0 / 12.0, False), (1.0 / 8.0, True)):
        assert 0.1 * share(strut(data, part * euler)) == pytest.approx(part, rel=1e-3)
        assert any("its reduction leaves out" in str(w.message) for w in recwarn) == told


def test_a_foot_that_holds_counts_as_a_clamp(recwarn):
    """A hinge holds the bending out of its plane: told is the change of a column that is clamped there and free."""
    part = 0.02
    told = 0.1 * share(strut(rod(), part * np.pi**2 * EI / L**2, foot=fmb.Revolute))
    assert told == pytest.approx(4.0 * part, rel=1e-3)
    assert not [w for w in recwarn if "leaves out" in str(w.message)]


def test_a_blade_that_spins_is_told(recwarn):
    """The basis of one axial shape has the mean of the tension along the blade: told is 1.4 times the change."""
    unit = np.sqrt(EI / MU) / L**2
    data = rod()
    for speed, told in ((0.7, False), (3.0, True)):
        change = (3.681**2 / 3.516**2 - 1.0) * speed**2
        assert change < 0.1 * share(brought_up(data, speed * unit)) < 1.5 * change
        assert any("its reduction leaves out" in str(w.message) for w in recwarn) == told


def test_a_blade_that_is_stretched_at_once_carries_more():
    """Spin without stretch at the start rings along the blade, and the hub pulls up to twice as hard."""
    change = (3.681**2 / 3.516**2 - 1.0) * 9.0
    with pytest.warns(fmb.ValidityWarning, match="its reduction leaves out"):
        assert 1.5 * change < 0.1 * share(spinning(rod(), 3.0 * np.sqrt(EI / MU) / L**2)) < 3.0 * change


def test_a_load_and_its_support_have_signs():
    """A rod that is pushed at both ends and pulled at both ends, by equal forces, carries nothing."""
    data, force = rod(), 0.5 * np.pi**2 * EI / L**2
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("b", data=data)],
        joints=[fmb.Fixed("hold", markers=("ground.origin", "b.a"))],
        forces=[
            fmb.PointLoad("press", marker="b.b", force=(-force, 0.0, 0.0)),
            fmb.PointLoad("pull", marker="b.b", force=(force, 0.0, 0.0)),
        ],
    )
    assert share(fmb.statics(model)) < 1e-6


def test_files_keep_the_matrices(tmp_path):
    """What was saved tells the same; a file without the matrices, as in former times, is read and tells nothing."""
    data, force = rod(), 0.5 * np.pi**2 * EI / (4.0 * L**2)
    with pytest.warns(fmb.ValidityWarning, match="its reduction leaves out"):
        expected = share(column(data, force))
    again = fmb.ModalNeutralData.load(data.save(tmp_path / "rod.h5"))
    with pytest.warns(fmb.ValidityWarning, match="its reduction leaves out"):
        assert share(column(again, force)) == expected
    former = replace(data, left_out=None, quality={**data.quality, "left_out": {"acceleration": [1.0, 1.0, 1.0]}})
    former = fmb.ModalNeutralData.load(former.save(tmp_path / "former.h5"))
    assert former.left_out is None
    assert "left out" not in column(former, force).statistics["share of validity"]["Body 'b'"]


def test_with_geometric_stiffness_nothing_is_left_out(recwarn):
    data = rod(geometric_stiffness=True)
    assert data.left_out is None
    column(data, 0.5 * np.pi**2 * EI / (4.0 * L**2))
    assert not [w for w in recwarn if "leaves out" in str(w.message)]


def test_a_stocky_body_carries_its_load(recwarn):
    """100 MPa in a block: Euler's load is seventy times as large."""
    solution = column(block(), 1e8 * 0.04**2)
    part = 1e8 / (np.pi**2 * 210e9 * (0.04**2 / 12.0) / (4.0 * 0.1**2))
    assert 0.8 * part < 0.1 * share(solution) < 1.2 * part
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
    back = turn.inv().as_matrix()
    place = {"at": origin, "rotation": turn, "markers": {"a": fmb.Pose.axes(x=back[:, 0], z=back[:, 2])}}
    speed = 3.0 * np.sqrt(EI / MU) / L**2
    place["velocity"] = np.cross((0.0, 0.0, speed), origin)
    with pytest.warns(fmb.ValidityWarning, match="its reduction leaves out"):
        assert share(spinning(moved, speed, **place)) == pytest.approx(share(spinning(data, speed)), rel=1e-5)


def bent(data, mirror=False, rotation=None):
    """Return the equilibrium of a rod that is clamped and pushed along and across, in axes of its own."""
    sign, turn = (-1.0 if mirror else 1.0), np.eye(3) if rotation is None else rotation
    force, moment = turn @ (-60.0, 3.0 * sign, 2.0), turn @ (sign, 0.5, -sign)
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"foot": fmb.Pose(at=turn @ (0.0, 0.0, 0.0), rotation=turn)})]
        + [fmb.FloatingBody("b", data=data, rotation=turn)],
        joints=[fmb.Fixed("hold", markers=("ground.foot", "b.a"))],
        forces=[fmb.PointLoad("press", marker="b.b", force=force, moment=moment)],
    )
    return fmb.statics(model)


@pytest.mark.filterwarnings("ignore:Body 'b'")
def test_a_mirrored_body_under_mirrored_loads():
    """A reflection turns moments about: the loads add up to the same change of stiffness."""
    data = rod()
    image = reduction.mirrored(data, "xz")
    assert share(bent(image, mirror=True)) == pytest.approx(share(bent(data)), rel=1e-6)
    turned = Rotation.from_rotvec((0.3, -0.8, 0.5)).as_matrix()
    assert share(bent(data, rotation=turned)) == pytest.approx(share(bent(data)), rel=1e-6)


@pytest.mark.parametrize("geometric_stiffness", [False, True])
@pytest.mark.parametrize("across", [0.0, 1e-3])
def test_past_the_buckling_load_one_warning(geometric_stiffness, across, recwarn):
    """Instability and large deformation are consequences, with other remedies: the load is told, and they with it."""
    times = 6.0 if across == 0.0 else 1.5 if geometric_stiffness else 3.0
    solution = column(rod(geometric_stiffness), times * np.pi**2 * EI / (4.0 * L**2), across)
    (told,) = [str(w.message) for w in recwarn if w.category is fmb.ValidityWarning]
    assert ("times the load under which" in told or "deforms by" in told) == geometric_stiffness
    assert ("its reduction leaves out" in told) != geometric_stiffness
    assert ("which is unstable" in told) == (across == 0.0)
    assert solution.statistics["warnings"] == [told]
