"""Equilibria along a load: von Mises' truss of two springs against its closed form,
and what is said at limit points.
"""

import numpy as np
import pytest
from scipy.optimize import brentq
from tolerances import SOLVER

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import FlexmbError, IntegrationError, ModelError
from flexmb.results import Solution

HALF, HEIGHT, STIFFNESS, LOAD = 1.0, 0.5, 1000.0, 200.0
FREE = np.hypot(HALF, HEIGHT)


def height_force(z):
    """Force (N, downwards) that holds the apex at the height z."""
    return 2.0 * STIFFNESS * z * (FREE / np.hypot(HALF, z) - 1.0)


LOWEST = np.sqrt((FREE * HALF**2) ** (2 / 3) - HALF**2)
"""Height of the apex at the limit load, where the cube of the length is FREE HALF^2."""


def truss(*, guide="ground.C", load=None, joints=(), bodies=()):
    load = fmb.expression(f"-{LOAD}*t") if load is None else load
    return fmb.Model(
        bodies=(
            fmb.Ground(markers={"A": (-HALF, 0, 0), "B": (HALF, 0, 0), "C": (0, 0, HEIGHT)}),
            fmb.PointMass("apex", mass=1.0, at=(0, 0, HEIGHT)),
            *bodies,
        ),
        joints=((fmb.InLine("guide", markers=(guide, "apex.center")),) if guide else ()) + tuple(joints),
        gravity=(0, 0, 0),
        forces=(
            fmb.SpringDamper("left", markers=("ground.A", "apex.center"), stiffness=STIFFNESS),
            fmb.SpringDamper("right", markers=("ground.B", "apex.center"), stiffness=STIFFNESS),
            fmb.PointLoad("P", marker="apex.center", force=(0, 0, load)),
        ),
        sensors=(fmb.Position("apex", marker="apex.center"),),
    )


def test_snap_through_of_the_truss():
    """Every point is an equilibrium; both limit points have the load and the height of the closed form."""
    path = fmb.statics(truss(), t=1.0, path=fmb.ArcLength())
    z = path["apex"][:, 2]
    np.testing.assert_allclose(LOAD * path.factor, height_force(z), atol=1e-8 * LOAD)
    first, second = path.limit_points
    for point, side in ((first, 1.0), (second, -1.0)):
        assert LOAD * point.load == pytest.approx(side * height_force(LOWEST), rel=SOLVER)
        assert z[point.sample] == pytest.approx(side * LOWEST, rel=1e-4)  # the load is flat there
        assert point.body == "Body 'apex'"
    assert (first.kind, second.kind) == ("maximum", "minimum")
    assert path.factor[-1] == 1.0
    assert path.status.ok


def test_snap_under_prescribed_displacement_has_no_limit_point():
    """Time drives the height; the reaction of the drive follows the closed form through its extrema."""
    carrier = fmb.RigidBody("carrier", mass=1.0, inertia=(1.0, 1.0, 1.0), at=(0, 0, HEIGHT), markers={"m": (0, 0, 0)})
    joints = (
        fmb.Prismatic("lift", markers=("ground.C", "carrier.m")),
        fmb.Drive("height", joint="lift", displacement=fmb.expression("-t")),
        fmb.Spherical("hold", markers=("carrier.m", "apex.center")),
    )
    model = truss(guide=None, load=0.0, joints=joints, bodies=(carrier,))
    path = fmb.statics(model, t=1.0, path=fmb.LoadSteps(steps=10))
    np.testing.assert_allclose(path.t, np.linspace(0.0, 1.0, 11), atol=1e-12)
    np.testing.assert_allclose(path["apex"][:, 2], HEIGHT - path.t, atol=1e-9)
    push = path[fmb.Reaction("r", joint="hold")][:, 2]
    np.testing.assert_allclose(-push, height_force(HEIGHT - path.t), atol=SOLVER * LOAD)


def test_load_steps_below_the_limit():
    end = 0.2
    path = fmb.statics(truss(), t=end, path=fmb.LoadSteps(steps=4))
    np.testing.assert_allclose(path.t, [0.0, 0.05, 0.1, 0.15, 0.2], atol=1e-15)
    np.testing.assert_allclose(height_force(path["apex"][:, 2]), LOAD * path.t, atol=1e-8 * LOAD)


def test_load_steps_name_the_limit_point():
    with pytest.raises(
        IntegrationError,
        match=r"limit point at the load factor 0\.214572 \(of 1\), where Body 'apex' "
        r"buckles.*path=flexmb\.ArcLength\(\)",
    ) as error:
        fmb.statics(truss(), t=1.0, path=fmb.LoadSteps(steps=10))
    np.testing.assert_allclose(error.value.solution.t, [0.0, 0.1, 0.2], atol=1e-12)


def test_statics_without_equilibrium_tells_the_load_that_was_reached():
    """A spring that softens holds 50 N at most: the message has that load, the body, and the arc length."""
    places = [-0.1, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 1.0, 2.0, 9.0]  # with fewer, the curve between 0.3 and 9 holds 100 N
    hold = fmb.table(places, [0.0, 0.0, -50.0, -20.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], of="slide")
    model = fmb.Model(
        bodies=(fmb.Ground(), fmb.RigidBody("cart", mass=1.0, inertia=(1, 1, 1), markers={"m": (0, 0, 0)})),
        joints=(fmb.Prismatic("slide", markers=("ground.origin", "cart.m")),),
        gravity=(0, 0, 0),
        forces=(
            fmb.PointLoad("hold", marker="cart.m", force=(0, 0, hold)),
            fmb.PointLoad("pull", marker="cart.m", force=(0, 0, fmb.expression("100*t"))),
        ),
    )
    with pytest.raises(
        IntegrationError,
        match=r"no equilibrium.*Body 'cart'.*limit point at the load factor 0\.5.* "
        r"\(of 1\), where Body 'cart' buckles.*ArcLength",
    ):
        fmb.statics(model, t=1.0, iterations=30)


def test_perfect_column_passes_a_bifurcation():
    """A rigid bar on a torsion spring under an axial load: the straight path branches at the load stiffness
    / length.
    """
    bar = fmb.RigidBody(
        "bar",
        mass=1.0,
        inertia=(0.1, 0.1, 0.1),
        at=(0, 0, 0),
        markers={"foot": fmb.Pose.axes((0, 0, 0), z=(0, 1, 0), x=(1, 0, 0)), "top": (0, 0, 2.0)},
    )
    ground = fmb.Ground(markers={"O": fmb.Pose.axes((0, 0, 0), z=(0, 1, 0), x=(1, 0, 0))})
    model = fmb.Model(
        bodies=(ground, bar),
        gravity=(0, 0, 0),
        joints=(fmb.Revolute("hinge", markers=("ground.O", "bar.foot")),),
        forces=(
            fmb.TorsionSpring("spring", joint="hinge", stiffness=10.0),
            fmb.PointLoad("P", marker="bar.top", force=(0, 0, fmb.expression("-10*t"))),
        ),
    )
    (point,) = fmb.statics(model, t=1.0, path=fmb.ArcLength()).limit_points
    assert point.kind == "bifurcation"
    assert point.load == pytest.approx(0.5, rel=1e-4)
    with pytest.raises(IntegrationError, match=r"a bifurcation at the load factor 0\.5"):
        fmb.statics(model, t=1.0, path=fmb.LoadSteps())


@pytest.mark.parametrize("points", range(4, 13))
def test_path_ends_after_its_points(points):
    """Also where the last arc passes a limit point."""
    path = fmb.statics(truss(), t=1.0, path=fmb.ArcLength(points=points))
    assert path.status.kind == "stopped"
    assert len(path.t) == points
    assert f"{points} points" in path.status.message
    assert all(path.factor[point.sample] == point.load for point in path.limit_points)


def test_path_is_saved_and_read(tmp_path):
    """Load factors that go down are no obstacle to the file."""
    path = fmb.statics(truss(), t=1.0, path=fmb.ArcLength())
    read = Solution.load(path.save(tmp_path / "path.h5"))
    np.testing.assert_array_equal(read.t, path.factor)
    np.testing.assert_array_equal(read["apex"], path["apex"])


def test_messages():
    with pytest.raises(ModelError, match=r"ArcLength: step = 2\.0.*a share between 0 and 1"):
        fmb.ArcLength(step=2.0)
    with pytest.raises(ModelError, match=r"ArcLength: points = 0.*whole number >= 1"):
        fmb.ArcLength(points=0)
    with pytest.raises(ModelError, match=r"LoadSteps: steps = 2.5.*whole number"):
        fmb.LoadSteps(steps=2.5)
    with pytest.raises(ModelError, match=r"LoadSteps: start = 'a'.*load factor"):
        fmb.LoadSteps(start="a")
    with pytest.raises(ModelError, match="begins and ends at the load factor 0"):
        fmb.statics(truss(), path=fmb.ArcLength())
    with pytest.raises(ModelError, match=r"path = 'riks'.*path=flexmb.ArcLength\(\)"):
        fmb.statics(truss(), t=1.0, path="riks")
    with pytest.raises(
        IntegrationError, match=r"no regular equilibrium: nothing holds Body 'apex', translation along y.*Support"
    ):
        fmb.statics(truss(guide=None), t=1.0, path=fmb.ArcLength())
    path = fmb.statics(truss(), t=1.0, path=fmb.ArcLength())
    with pytest.raises(FlexmbError, match=r"the load goes up and down.*phases\[0\]\.instant"):
        path.state(0.1)


BOTH_PATHS = pytest.mark.parametrize("path", [fmb.LoadSteps(steps=5), fmb.ArcLength()], ids=["steps", "arc"])


@BOTH_PATHS
@pytest.mark.parametrize(
    ("across", "along", "at_end"),
    [("10*t", "0*t", (10, 0)), ("10", "20*t", (10, 20)), ("1 + t", "-30*t", (2, -30)), ("10", "-30*t", (10, -30))],
)
def test_a_rigid_bar_on_a_hinge_does_not_buckle(path, across, along, at_end):
    """Its hinge and a spring about it hold it: k a = (Fx cos a - Fy sin a) L. Its translations have no stiffness;
    rounding in the place of one made the hinge yield, and the path was told to end at bifurcations.
    """
    bar = fmb.RigidBody("bar", mass=1.0, inertia=(1.0, 1.0, 1.0), markers={"foot": (0, 0, 0), "tip": (0, 1, 0)})
    push = (fmb.expression(across), fmb.expression(along), 0.0)
    model = fmb.Model(
        bodies=[fmb.Ground(), bar],
        joints=[fmb.Revolute("hinge", markers=("ground.origin", "bar.foot"))],
        forces=[
            fmb.TorsionSpring("spring", joint="hinge", stiffness=100.0),
            fmb.PointLoad("push", marker="bar.tip", force=push),
        ],
        sensors=[fmb.Position("tip", marker="bar.tip")],
    )
    found = fmb.statics(model, t=1.0, path=path)
    assert found.t[-1] == 1.0
    assert found.limit_points == ()
    fx, fy = at_end
    a = brentq(lambda a: 100.0 * a - fx * np.cos(a) + fy * np.sin(a), -1.0, 1.0)
    np.testing.assert_allclose(found["tip"][-1], [np.sin(a), np.cos(a), 0.0], atol=1e-8)


def strut(press: float, side: float):
    """A slender strut of 1 m between hinges, that is pressed by ``press * t`` and pushed aside in its middle."""
    diameter, steel = 0.01, fmb.Material(young=210e9, poisson=0.3, density=7850.0)
    points = np.column_stack([np.linspace(0.0, 1.0, 17), np.zeros((17, 2))])
    sets = {"a": [0], "mid": [8], "b": [16]}
    fe = fem.frame(points, section=fem.Section.solid_circle(diameter), material=steel, node_sets=sets, shear=False)
    data = reduction.reduce(fe, {name: name for name in sets}, 6, geometric_stiffness=True)
    ends = {"a": fmb.Pose.axes((0, 0, 0), z=(0, 1, 0)), "b": fmb.Pose.axes((1, 0, 0), z=(1, 0, 0))}
    body = fmb.FloatingBody("s", data=data, markers={"a": fmb.Pose.axes(z=(0, 1, 0))})
    return fmb.Model(
        bodies=[fmb.Ground(markers=ends), body],
        joints=[
            fmb.Revolute("left", markers=("ground.a", "s.a")),
            fmb.InLine("right", markers=("ground.b", "s.b")),
        ],
        forces=[
            fmb.PointLoad("press", marker="s.b", force=(fmb.expression("-p*t", p=press), 0, 0)),
            fmb.PointLoad("side", marker="s.mid", force=(0, 0, -side)),
        ],
        sensors=[fmb.Position("middle", marker="s.mid")],
    )


EULER, BENDING = np.pi**2 * 210e9 * np.pi * 0.01**4 / 64.0, 210e9 * np.pi * 0.01**4 / 64.0


@BOTH_PATHS
def test_a_load_that_stays_beside_one_that_grows(path):
    """Q L^3 / (48 E I) 3 (tan u - u) / u^3, u = pi/2 sqrt(P / P_E) (Timoshenko & Gere, Theory of Elastic Stability)."""
    found = fmb.statics(strut(0.3 * EULER, 20.0), t=1.0, path=path)
    u = 0.5 * np.pi * np.sqrt(0.3)
    expected = 20.0 / (48.0 * BENDING) * 3.0 * (np.tan(u) - u) / u**3
    assert found.limit_points == ()
    assert -found["middle"][-1, 2] == pytest.approx(expected, rel=1e-3)


def test_beyond_the_buckling_load_the_way_there_is_told():
    with pytest.raises(IntegrationError) as caught:
        fmb.statics(strut(1.2 * EULER, 1e-3), t=1.0, path=fmb.LoadSteps(steps=12))
    factor = float(caught.value.found.partition("load factor ")[2].partition(" ")[0])
    assert factor == pytest.approx(1.0 / 1.2, rel=2e-3)
    assert "where Body 's' buckles" in caught.value.found
