"""RC03: two masses and two springs in redundant coordinates, whose mass matrix has rank two of three.

Once as the matrices of Udwadia & Phohomsiri (2006), to every formulation; once as a mechanism: the springs join a
weightless carriage that is driven at a constant distance. Reached: accelerations 1e-13 (recursion as well), motion over
2 s with DOP853 4e-9 m, IDA at 1e-9: 6e-8 m, generalized-alpha with h = 5e-4: 8e-6 m; frequencies 1e-9.
"""

import numpy as np
import pytest
from scipy import sparse
from scipy.integrate import solve_ivp

import flexmb as fmb
from flexmb.integrate.matrices import Equations

FORMULATIONS = (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri())
MOTION = 1e-6


def equations(case, x) -> Equations:
    """The equations in x1, q1, x2 at a position."""
    p = case["model"]
    G = sparse.csr_matrix([[-1.0, 1.0, 0.0]])
    return Equations(
        M=sparse.csr_matrix(p["M"]),
        L=G.T.tocsr(),
        G=G,
        f=np.array([-p["k1"] * x[0], 0.0, -p["k2"] * x[2]]),
        b=np.zeros(1),
        velocity=np.zeros(1),
        position=np.zeros(1),
        weight=np.ones(1),
        least_inertia=np.zeros(3),
    )


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=repr)
def test_three_coordinates(reference, formulation):
    case = reference("RC03")
    start = np.array([0.1, 0.1 + case["model"]["d"], -0.05])
    a, lam = formulation.solve(equations(case, start))
    np.testing.assert_allclose(a, [case["reference"]["acc0"][k] for k in ("x1", "q1", "x2")], atol=1e-10)
    assert lam == pytest.approx(17.5 - 10.0)  # m1 x1'' + k1 x1 = -lam
    times = [float(t) for t in case["reference"]["x"]]
    motion = solve_ivp(
        lambda t, y: np.concatenate([y[3:], formulation.solve(equations(case, y))[0]]),
        (0, times[-1]),
        np.concatenate([start, np.zeros(3)]),
        t_eval=times,
        method="DOP853",
        rtol=1e-9,
        atol=1e-11,
    )
    for y, expected in zip(motion.y.T, case["reference"]["x"].values(), strict=True):
        np.testing.assert_allclose([y[0], y[2]], list(expected.values()), atol=MOTION)
        assert y[1] - y[0] == pytest.approx(case["model"]["d"], abs=1e-10)


def carriage(case, mass=0.0) -> fmb.Model:
    p = case["model"]
    along = fmb.Pose.axes((0, 0, 0), x=(0, 1, 0), z=(1, 0, 0))
    behind = {"rail": along, "hook": (-10.0, 0, 0)}
    inertia = (1.0, 1.0, 1.0)
    bodies = [
        fmb.Ground(markers=behind),
        fmb.RigidBody("one", mass=p["m1"], inertia=inertia, at=(0.1, 0, 0), markers={"rail": along}),
        fmb.RigidBody("carriage", mass=mass, inertia=(mass,) * 3, at=(0.1 + p["d"], 0, 0), markers=behind),
        fmb.RigidBody("two", mass=p["m2"], inertia=inertia, at=(0.05 + p["d"], 0, 0), markers={"rail": along}),
    ]
    joints = [
        fmb.Prismatic("x1", markers=("ground.rail", "one.rail")),
        fmb.Prismatic("link", markers=("one.rail", "carriage.rail")),
        fmb.Drive("distance", joint="link", displacement=p["d"]),
        fmb.Prismatic("x2", markers=("carriage.rail", "two.rail")),
    ]
    forces = [
        fmb.SpringDamper("k1", markers=("ground.hook", "one.center"), stiffness=p["k1"], length=10.0),
        fmb.SpringDamper("k2", markers=("carriage.hook", "two.center"), stiffness=p["k2"], length=10.0),
    ]
    sensors = [fmb.JointCoordinate(name, joint=name) for name in ("x1", "x2")]
    return fmb.Model(bodies=bodies, joints=joints, forces=forces, sensors=sensors)


@pytest.mark.parametrize("formulation", [*FORMULATIONS, fmb.Recursive()], ids=repr)
def test_accelerations_with_a_weightless_carriage(reference, formulation):
    case = reference("RC03")
    found, expected = fmb.accelerations(carriage(case), formulation=formulation), case["reference"]["acc0"]
    x1, q1, two = (found[name][0] for name in ("one", "carriage", "two"))
    np.testing.assert_allclose([x1, q1, two - q1], [expected[k] for k in ("x1", "q1", "x2")], atol=1e-10)
    assert found.reactions["distance"][0] == pytest.approx(7.5, abs=1e-9)


@pytest.mark.parametrize(
    ("integrator", "tolerance"),
    [
        (fmb.Explicit(), MOTION),
        (fmb.Explicit(formulation=fmb.UdwadiaPhohomsiri()), MOTION),
        (fmb.IDA(rtol=1e-9, atol=1e-10), MOTION),
        (fmb.GeneralizedAlpha(step=5e-4), 1e-5),
    ],
    ids=["explicit", "Udwadia-Phohomsiri", "IDA", "alpha"],
)
def test_motion_with_a_weightless_carriage(reference, integrator, tolerance):
    case = reference("RC03")
    expected = case["reference"]["x"]
    solution = fmb.simulate(
        carriage(case), case["duration_s"], samples=[0.0, *map(float, expected)], integrator=integrator
    )
    for name in ("x1", "x2"):
        np.testing.assert_allclose(solution[name][1:], [x[name] for x in expected.values()], atol=tolerance)


def test_frequencies(reference):
    case = reference("RC03")
    found = 2 * np.pi * fmb.linearize(carriage(case), fmb.statics(carriage(case))).frequencies
    np.testing.assert_allclose(found, case["reference"]["omega_rad_s"], rtol=1e-8)


def test_a_rod_without_thickness():
    """No inertia about its axis, which its hinge holds; on a ball joint nothing does, and the body is named."""
    rod = fmb.RigidBody(
        "rod", mass=1.0, inertia=(0, 1 / 12, 1 / 12), center_of_mass=(0.5, 0, 0), markers={"end": (0, 0, 0)}
    )
    ground, ends = fmb.Ground(), ("ground.origin", "rod.end")
    hinged = fmb.Model(gravity=(0, -9.81, 0), bodies=[ground, rod], joints=[fmb.Revolute("pin", markers=ends)])
    for formulation in (*FORMULATIONS, fmb.Recursive()):
        assert fmb.accelerations(hinged, formulation=formulation)["rod"][5] == pytest.approx(-1.5 * 9.81, rel=1e-12)
    with pytest.raises(fmb.CompileError, match=r"Body 'rod'.*no inertia about its x-axis") as caught:
        fmb.check(fmb.Model(bodies=[ground, rod], joints=[fmb.Spherical("ball", markers=ends)]))
    assert caught.value.expected
    assert caught.value.remedy


def test_a_free_body_without_mass_is_named():
    free = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("ghost", mass=0.0), fmb.PointMass("real", mass=1.0, at=(1, 0, 0))],
        joints=[fmb.Rod("rod", markers=("ghost.center", "real.center"))],
    )
    with pytest.raises(fmb.CompileError, match=r"Body 'ghost'.*has no inertia"):
        fmb.check(free)
    block = fmb.RigidBody("ghost", mass=0.0, inertia=(0, 0, 0))
    with pytest.raises(fmb.CompileError, match=r"Body 'ghost'.*no (mass|inertia)"):
        fmb.check(fmb.Model(bodies=[fmb.Ground(), block, free.bodies[2]], joints=free.joints))
