"""A body without geometric stiffness says so where its loads would change its stiffness.

Reference: Euler's column, pi^2 EI / (4 L^2); the rotating cantilever, whose lowest frequency in flapping rises from
3.516 to 3.681 at a speed of 1 (in units of sqrt(EI / mu) / L^2; Wright et al. 1982), so by 9.6 % in its square.
"""

import h5py
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.model.modal_neutral_file import KNOWN

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


@pytest.mark.parametrize(("foot", "euler"), [(fmb.Revolute, np.pi**2), (fmb.Fixed, 20.1907)])
def test_a_foot_that_holds(foot, euler, recwarn):
    """A hinge lets the strut bend as between pins, in its plane; a clamped foot: tan x = x, x^2 = 20.1907."""
    told = 0.1 * share(strut(rod(), 0.05 * euler * EI / L**2, foot=foot))
    assert told == pytest.approx(0.05, rel=2e-3)
    assert not [w for w in recwarn if "leaves out" in str(w.message)]


@pytest.mark.parametrize(("length", "slenderness"), [(0.01, 1e-2), (1e4, 1e-2), (1.0, 1e-4)])
def test_what_a_clamp_holds_does_not_depend_on_size(length, slenderness):
    """Places in m and turns in rad are compared by direction: a clamped column is told its share of Euler's load."""
    points = np.column_stack([np.linspace(0.0, length, 13), np.zeros((13, 2))])
    section = fem.Section.solid_circle(slenderness * length)
    fe = fem.frame(points, section=section, material=STEEL, node_sets={"a": [0], "b": [12]})
    data = reduction.reduce(fe, {"a": "a", "b": "b"}, 4)
    euler = np.pi**2 / 4 * 210e9 * np.pi * (slenderness * length) ** 4 / 64 / length**2
    assert 0.1 * share(column(data, 0.05 * euler)) == pytest.approx(0.05, rel=2e-3)


def shaft(place, bearings, nodes=20):
    """Return an equilibrium of a shaft that bearings hold at its foot and at a place, with a load on its free end."""
    points = np.column_stack([np.linspace(0.0, L, nodes + 1), np.zeros((nodes + 1, 2))])
    sets = {"a": [0], "m": [round(place / L * nodes)], "b": [nodes]}
    fe = fem.frame(points, section=fem.Section.solid_circle(D), material=STEEL, node_sets=sets)
    data = reduction.reduce(fe, {name: name for name in sets}, 4)
    span, over = place / L, 1.0 - place / L
    zero = lambda x: np.tan(x * over) * (1.0 - x * span / np.tan(x * span)) - x * span  # noqa: E731
    x = brentq(zero, 1e-3, min(0.5 * np.pi / over, np.pi / span) * (1.0 - 1e-9))
    bodies, joints, forces = bearings(data, place)
    load = fmb.PointLoad("press", marker="b.b", force=(-0.05 * x**2 * EI / L**2, 0.0, 0.0))
    return fmb.statics(fmb.Model(bodies=bodies, joints=joints, forces=[*forces, load]))


def along(place):
    return fmb.Pose.axes(at=(place, 0.0, 0.0), z=(1.0, 0.0, 0.0), x=(0.0, 1.0, 0.0))


def in_balls(data, place):
    ground = fmb.Ground(markers={"m": along(place)})
    joints = [
        fmb.Spherical("A", markers=("ground.origin", "b.a")),
        fmb.InLine("B", markers=("ground.m", "b.m")),
    ]
    return [ground, fmb.FloatingBody("b", data=data)], joints, []


def on_stands(data, place):
    """Two stands beside the body, one bolted to the ground, the other on a hinge that is driven."""
    ground = fmb.Ground(markers={"m": fmb.Pose(at=(place, 0.0, -0.1))})
    stand = {"mass": 1.0, "inertia": (1.0, 1.0, 1.0)}
    first = fmb.RigidBody("s", **stand)
    second = fmb.RigidBody("t", **stand, at=(place, 0.0, 0.0), markers={"top": along(0.0), "foot": (0.0, 0.0, -0.1)})
    joints = [
        fmb.Fixed("bolt", markers=("ground.origin", "s.center")),
        fmb.Spherical("A", markers=("s.center", "b.a")),
        fmb.Revolute("foot", markers=("ground.m", "t.foot")),
        fmb.Drive("still", joint="foot", angle=0.0),
        fmb.InLine("B", markers=("t.top", "b.m")),
    ]
    return [ground, first, second, fmb.FloatingBody("b", data=data)], joints, []


def in_bushings(data, place):
    """Bearings that are stiff across, and soft against turning."""
    ground = fmb.Ground(markers={"m": fmb.Pose(at=(place, 0.0, 0.0))})
    stiff = (1e9, 1e9, 1e9, 1e-3, 1e-3, 1e-3)
    forces = [
        fmb.Bushing(f"at {name}", markers=(f"ground.{to}", f"b.{name}"), stiffness=stiff)
        for name, to in (("a", "origin"), ("m", "m"))
    ]
    return [ground, fmb.FloatingBody("b", data=data)], [], forces


@pytest.mark.parametrize("place", [0.1, 0.2, 0.5, 0.8])
def test_a_shaft_that_overhangs_two_bearings(place):
    """Both bearings together hold the shaft against turning: tan(x b) (1 - x a cot(x a)) = x a, spans a and b.

    Timoshenko & Gere, Theory of Elastic Stability: the span turns at its bearing with P a / (1 - x a cot(x a)).
    """
    assert 0.1 * share(shaft(place, in_balls)) == pytest.approx(0.05, rel=2e-3)


def test_a_shaft_in_bearings_of_other_bodies():
    """The same, where one stand is bolted to the ground and the other one is held by a drive."""
    assert 0.1 * share(shaft(0.2, on_stands)) == pytest.approx(0.05, rel=2e-3)


def test_a_shaft_in_bearings_that_yield():
    """Bearings of springs may hold turns: told is at least what they carry, at most what a clamp at one would."""
    told = 0.1 * share(shaft(0.2, in_bushings))
    assert 0.05 * (1.0 - 2e-3) < told < 4.0 * 0.05


def test_a_rod_clamped_at_both_ends_with_a_load_across():
    """Its frequencies fall by 0.02 % in the square; the coupling of bending and torsion is what is left: 2 %."""
    points = np.column_stack([np.linspace(0.0, L, 13), np.zeros((13, 2))])
    sets = {"a": [0], "m": [6], "b": [12]}
    fe = fem.frame(points, section=fem.Section.solid_circle(D), material=STEEL, node_sets=sets)
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"end": (L, 0.0, 0.0)}),
            fmb.FloatingBody("b", data=reduction.reduce(fe, {name: name for name in sets}, 4)),
        ],
        joints=[fmb.Fixed("A", markers=("ground.origin", "b.a")), fmb.Fixed("B", markers=("ground.end", "b.b"))],
        forces=[fmb.PointLoad("across", marker="b.m", force=(0.0, 100.0, 0.0))],
    )
    assert 0.1 * share(fmb.statics(model)) < 0.03


def test_a_body_that_is_stretched_has_not_buckled(recwarn):
    """Five times Euler's load in tension, and a bend of more than a tenth: both are told, in equilibrium too."""
    euler = np.pi**2 * EI / (4.0 * L**2)
    solution = column(rod(), -5.0 * euler, across=8.0 * euler)
    told = [str(w.message) for w in recwarn if w.category is fmb.ValidityWarning]
    assert any("leaves out" in text for text in told)
    assert any("deforms by" in text for text in told)
    (known,) = solution.statistics["share of validity"].values()
    assert known["softening left out"] < 1.0 < 0.1 * known["left out"]


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
    """What was saved tells the same."""
    data, force = rod(), 0.5 * np.pi**2 * EI / (4.0 * L**2)
    with pytest.warns(fmb.ValidityWarning, match="its reduction leaves out"):
        expected = share(column(data, force))
    again = fmb.ModalNeutralData.load(data.save(tmp_path / "rod.h5"))
    with pytest.warns(fmb.ValidityWarning, match="its reduction leaves out"):
        assert share(column(again, force)) == expected


def test_files_of_former_times_say_that_it_is_not_known(tmp_path):
    """Files without the mark, or with numbers of another kind, are read, and what is not known is told."""
    data, force = rod(), 0.5 * np.pi**2 * EI / (4.0 * L**2)
    for name, lacking in (("before", ("left_out",)), ("numbers", ("left_out/translations", "left_out/compliance"))):
        path = data.save(tmp_path / f"{name}.h5")
        with h5py.File(path, "r+") as file:
            del file.attrs[KNOWN]
            for part in lacking:
                del file[part]
        with pytest.warns(fmb.ValidityWarning, match="not known by how much loads.*Reduce it again"):
            former = fmb.ModalNeutralData.load(path)
        assert former.left_out is None
        solution = column(former, force)
        assert "left out" not in solution.statistics["share of validity"]["Body 'b'"]
        assert "not known" in " ".join(solution.statistics["notes"])


def test_geometric_stiffness_that_is_switched_off_is_noted():
    """Its reduction has it, so nothing tells what is left out: before, not a word was said."""
    data, force = rod(geometric_stiffness=True), 0.5 * np.pi**2 * EI / (4.0 * L**2)
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("b", data=data, geometric_stiffness=False)],
        joints=[fmb.Fixed("foot", markers=("ground.origin", "b.a"))],
        forces=[fmb.PointLoad("press", marker="b.b", force=(-force, 0, 0))],
    )
    notes = " ".join(fmb.statics(model).statistics.get("notes", []))
    notes += " ".join(fmb.simulate(model, 1e-3, samples=2).statistics["notes"])
    assert "Body 'b' has geometric stiffness that is not used (geometric_stiffness=False): no run warns" in notes


@pytest.mark.parametrize(
    ("groups", "of"),
    [
        (("inertia",), " of interface and loads"),
        (("interface", "loads", "preload"), " of inertia"),
        (("preload",), ""),
        (("inertia", "interface", "loads"), None),
        (True, None),
    ],
    ids=str,
)
def test_geometric_stiffness_that_is_switched_off_in_part_is_noted(groups, of, recwarn):
    """At 1.5 times Euler's load the rod stood without a word, since the matrices of its interfaces did not act."""
    data, force = rod(geometric_stiffness=True), 1.5 * np.pi**2 * EI / (4.0 * L**2)
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("b", data=data, geometric_stiffness=groups)],
        joints=[fmb.Fixed("foot", markers=("ground.origin", "b.a"))],
        forces=[fmb.PointLoad("press", marker="b.b", force=(-force, 0, 0))],
    )
    notes = " ".join(fmb.simulate(model, 1e-4, samples=2).statistics["notes"])
    said = f"Body 'b' has geometric stiffness{of} that is not used (geometric_stiffness={groups!r}): no run warns"
    assert (said in notes) if of is not None else "not used" not in notes


def test_what_leaves_nothing_out_is_read_without_a_word(tmp_path, recwarn):
    """Bodies with geometric stiffness, and such as have no elastic shapes, need no matrices of what is left out."""
    stiff, again = rod(geometric_stiffness=True), tmp_path / "stiff.h5"
    with h5py.File(stiff.save(again), "r+") as file:
        file.attrs.pop(KNOWN, None)
    fmb.ModalNeutralData.load(again)
    assert not list(recwarn)


def test_with_geometric_stiffness_nothing_is_left_out(recwarn):
    solution = column(rod(geometric_stiffness=True), 0.5 * np.pi**2 * EI / (4.0 * L**2))
    assert not [w for w in recwarn if "leaves out" in str(w.message)]
    (known,) = solution.statistics["share of validity"].values()
    assert "left out" not in known
    assert known["load"] == pytest.approx(0.5, rel=1e-3)


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
    times = 6.0 if across == 0.0 else 1.5 if geometric_stiffness else 1.4
    solution = column(rod(geometric_stiffness), times * np.pi**2 * EI / (4.0 * L**2), across)
    (told,) = [str(w.message) for w in recwarn if w.category is fmb.ValidityWarning]
    assert ("times the load under which" in told or "deforms by" in told) == geometric_stiffness
    assert ("its reduction leaves out" in told) != geometric_stiffness
    assert ("which is unstable" in told) == (across == 0.0)
    assert solution.statistics["warnings"] == [told]
