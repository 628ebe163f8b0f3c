"""One driven, damped four-bar in space by both integrators: sensors agree, energy is balanced, redundancy or not.

Reached: sensors of generalized-alpha (h = 2e-4) and IDA (1e-9) agree within 1e-5 of their largest value; energy balance
2e-6 (generalized-alpha) and 1e-6 (IDA) of the largest term.
"""

import numpy as np
import pytest

import flexmb as fmb

INTEGRATORS = {
    "alpha": fmb.GeneralizedAlpha(step=2e-4),
    "alpha adaptive": fmb.GeneralizedAlpha(rtol=1e-8),
    "IDA": fmb.IDA(rtol=1e-9, atol=1e-9),
}
BALANCE = 1e-4


def four_bar(free: bool) -> fmb.Model:
    """Crank 0.2 m driven at 20 rad/s, coupler 0.5 m, rocker 0.4 m, ground 0.5 m;
    with `free`, no equation is redundant.
    """
    crank = fmb.RigidBody.rod("crank", length=0.2, mass=0.5, radius=0.01, rotation=(0, 0, np.pi / 2))
    C = np.array([0.5 + 0.4 * np.cos(1.9), 0.4 * np.sin(1.9)])
    along = C - (0.0, 0.2)
    coupler = fmb.RigidBody.rod(
        "coupler",
        length=float(np.linalg.norm(along)),
        mass=1.0,
        radius=0.01,
        at=(0, 0.2, 0),
        rotation=(0, 0, np.arctan2(along[1], along[0])),
    )
    rocker = fmb.RigidBody.rod("rocker", length=0.4, mass=0.8, radius=0.01, at=(0.5, 0, 0), rotation=(0, 0, 1.9))
    b, c = (fmb.Spherical, fmb.Universal) if free else (fmb.Revolute, fmb.Revolute)
    # a universal joint keeps z-axes perpendicular: that of its second marker lies along the rocker
    tip = {"tip": fmb.Pose.axes((0.4, 0, 0), x=(0, 0, 1), z=(1, 0, 0))} if free else {"tip": (0.4, 0, 0)}
    rocker = rocker.replaced(markers={**rocker.markers, **tip})
    return fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(markers={"A": (0, 0, 0), "D": (0.5, 0, 0), "S": (0.6, 0.6, 0)}), crank, coupler, rocker],
        joints=[
            fmb.Revolute("A", markers=("ground.A", "crank.start")),
            b("B", markers=("crank.end", "coupler.start")),
            c("C", markers=("coupler.end", "rocker.tip")),
            fmb.Revolute("D", markers=("ground.D", "rocker.start")),
            fmb.Drive("motor", joint="A", angle=fmb.expression("pi/2 + 12*t + 0.4*sin(15*t)")),
        ],
        forces=[
            fmb.SpringDamper("spring", markers=("ground.S", "rocker.tip"), stiffness=2e3, damping=30.0),
            fmb.PointLoad("push", marker="coupler.center", force=(fmb.harmonic(amplitude=20.0, frequency=3.0), 5.0, 0)),
        ],
        sensors=[
            fmb.Position("C at", marker="rocker.tip"),
            fmb.Velocity("C speed", marker="rocker.tip"),
            fmb.Acceleration("C acceleration", marker="rocker.tip"),
            fmb.JointCoordinate("rocker angle", joint="D"),
            fmb.Reaction("torque", joint="motor"),
            fmb.Reaction("C force", joint="C"),
            fmb.ForceOf("spring force", force="spring"),
            fmb.ConstraintError("closure"),
            *(fmb.Energy(kind, kind=kind) for kind in ("kinetic", "strain", "potential", "total")),
        ],
    )


@pytest.fixture(scope="module", params=[False, True], ids=["redundant", "free"])
def solutions(request):
    model = four_bar(request.param)
    report = fmb.check(model)
    assert (report.mobility, bool(report.redundant)) == (0, not request.param)
    return {name: fmb.simulate(model, 0.6, samples=121, integrator=i) for name, i in INTEGRATORS.items()}


def test_sensors_agree(solutions):
    for sensor in solutions["IDA"].model.sensors:
        expected = solutions["IDA"][sensor.name]
        if sensor.name == "closure":
            continue
        scale = max(np.abs(expected).max(), 1e-3)
        for name, tolerance in (("alpha", 2e-5), ("alpha adaptive", 5e-4)):
            found = solutions[name][sensor.name]
            np.testing.assert_allclose(found / scale, expected / scale, rtol=0, atol=tolerance, err_msg=sensor.name)


@pytest.mark.parametrize("name", INTEGRATORS)
def test_energy_balance(solutions, name):
    """Kinetic + potential + strain - work of loads - work of drives + dissipated = constant."""
    solution = solutions[name]
    loads, drives, dissipated = solution.phases[0].works.T
    assert np.abs(drives).max() > 1.0
    assert dissipated[-1] > 1.0
    balance = solution["total"] - loads - drives + dissipated
    largest = max(np.abs(x).max() for x in (loads, drives, dissipated, solution["kinetic"], solution["potential"]))
    assert np.ptp(balance) < BALANCE * largest


@pytest.mark.parametrize(("name", "tolerance"), [("alpha", 1e-9), ("alpha adaptive", 1e-8), ("IDA", 1e-7)])
def test_loop_stays_closed(solutions, name, tolerance):
    assert solutions[name]["closure"].max() < tolerance


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(step=2e-3), fmb.GeneralizedAlpha(rtol=1e-6)])
def test_long_runs_do_not_drift(integrator):
    """A double pendulum over 100 s: constraints stay closed, energy falls by numerical damping only.

    Rounding decides which of its motions it takes after 20 s, so that the loss of one is by chance (0.11 to 0.20 J of
    29 J in adaptive steps): the middle one of three counts.
    """
    runs = [double_pendulum(1.0 + k * 1e-12, integrator) for k in range(3)]
    assert max(run["closure"].max() for run in runs) < 1e-8
    assert np.median([np.ptp(run["energy"]) for run in runs]) < 0.2


def double_pendulum(mass: float, integrator) -> fmb.Solution:
    """Return 100 s of two rods that begin level."""
    rods = [fmb.RigidBody.rod(f"rod{k}", length=1.0, mass=mass, radius=0.05, at=(k, 0, 0)) for k in range(2)]
    joints = [
        fmb.Revolute("top", markers=("ground.origin", "rod0.start")),
        fmb.Revolute("mid", markers=("rod0.end", "rod1.start")),
    ]
    model = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(), *rods],
        joints=joints,
        sensors=[fmb.Energy("energy"), fmb.ConstraintError("closure")],
    )
    return fmb.simulate(model, 100.0, samples=101, integrator=integrator)
