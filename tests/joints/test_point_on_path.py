"""Points on tracks that deform: loads and masses that cross a beam, on reduced and on ANCF bodies, in all formulations.

References: Inglis (A Mathematical Treatise on Vibrations in Railway Bridges, 1934) and Fryba (Vibration of Solids and
Structures under Moving Loads, 1999, eq. 1.31) for a constant force at constant speed; for a mass Galerkin's method with
sine modes (Fryba, ch. 8), integrated here by DOP853.
"""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb import fem, reduction

L, HEIGHT, WIDTH = 10.0, 0.1, 0.2
STEEL = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
EI, LINE = STEEL.young * WIDTH * HEIGHT**3 / 12.0, STEEL.density * WIDTH * HEIGHT
W1 = np.pi**2 / L**2 * np.sqrt(EI / LINE)
PATH = [f"beam.p{k}" for k in range(11)]
FORCE = 1e3


@cache
def reduced() -> fmb.ModalNeutralData:
    x = np.linspace(0.0, L, 21)
    fe = fem.frame(
        points=np.column_stack([x, 0 * x, 0 * x]),
        section=fem.Section.rectangle(WIDTH, HEIGHT),
        material=STEEL,
        orientation=(0, 1, 0),
    )
    stations = {f"p{k}": (L * k / 10, 0, 0) for k in range(11)}
    return reduction.reduce(fe, interfaces={"left": [0], "right": [20]}, modes=6, stations=stations)


def crossing(speed, mass, weight, body="reduced"):
    """A simply supported beam; a point mass under a force is pulled across it at constant speed."""
    axis = fmb.Pose.axes(z=(0, 1, 0), x=(1, 0, 0))
    if body == "reduced":
        beam = fmb.FloatingBody("beam", data=reduced(), markers={"left": axis, "right": (0, 0, 0)})
        ends = ("beam.left", "beam.right")
    else:
        beam = fmb.AncfBeam(
            "beam",
            points=((0, 0, 0), (L, 0, 0)),
            elements=10,
            section=fem.Section.rectangle(WIDTH, HEIGHT),
            material=STEEL,
            markers={f"p{k}": k / 10 for k in range(11)},
        )
        ends = ("beam.p0", "beam.p10")
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"l": axis, "r": fmb.Pose.axes((L, 0, 0), z=(1, 0, 0))}),
            beam,
            fmb.PointMass("load", mass=mass, velocity=(speed, 0, 0)),
        ],
        joints=[
            fmb.Spherical("pin", markers=("ground.l", ends[0])),
            fmb.InLine("roller", markers=("ground.r", ends[1])),
            fmb.PointOnPath("wheel", markers=(PATH[0], "load.center"), through=PATH[1:]),
            fmb.Constraint(
                "pull", over=[fmb.Position("x", marker="load.center")], equation="x[0] = v*t", parameters={"v": speed}
            ),
        ],
        forces=[fmb.PointLoad("weight", marker="load.center", force=(0, 0, -weight))],
        sensors=[fmb.Position("mid", marker="beam.p5"), fmb.Reaction("wheel", joint="wheel")],
    )


def inglis(t, speed, force):
    """Deflection in the middle under a constant force, m."""
    alpha, w = speed * np.pi / (L * W1), np.zeros_like(t)
    for k in range(1, 60):
        shape = np.sin(k * np.pi / 2) / (k**2 * (k**2 - alpha**2))
        w += shape * (np.sin(k * np.pi * speed * t / L) - alpha / k * np.sin(k * k * W1 * t))
    return 2.0 * force * L**3 / (np.pi**4 * EI) * w


def moving_mass(t, speed, mass, weight, n=8):
    """Deflection in the middle under a mass that follows the beam, m: the force is weight - mass d2 w(vt, t)/dt2."""
    k = np.arange(1, n + 1) * np.pi / L
    modal = 0.5 * LINE * L

    def rates(time, y):
        q, dq = y[:n], y[n:]
        s, c = np.sin(k * speed * time), np.cos(k * speed * time)
        M = modal * np.eye(n) + mass * np.outer(s, s)
        along = 2.0 * speed * (k * c) @ dq - speed**2 * (k**2 * s) @ q
        return np.concatenate([dq, np.linalg.solve(M, s * (weight - mass * along) - 0.5 * L * EI * k**4 * q)])

    found = solve_ivp(rates, (0, t[-1]), np.zeros(2 * n), method="DOP853", t_eval=t, rtol=1e-9, atol=1e-12)
    return np.sin(k * L / 2) @ found.y[:n]


@pytest.mark.parametrize("alpha", [0.1, 0.5, 0.9, 1.3])
def test_a_force_crosses_a_beam(alpha):
    """At a tenth, half, nine tenths of the critical speed and beyond it."""
    speed = float(alpha * W1 * L / np.pi)
    model = crossing(speed, 1e-3 * LINE * L, FORCE)
    solution = fmb.simulate(model, 0.98 * L / speed, samples=101, integrator=fmb.GeneralizedAlpha(rtol=1e-5))
    expected = inglis(solution.t, speed, FORCE)
    np.testing.assert_allclose(-solution["mid"][:, 2], expected, atol=4e-3 * np.abs(expected).max())


@pytest.mark.parametrize("body", ["reduced", "ancf"])
def test_a_mass_crosses_a_beam(body):
    """Half the mass of the beam at half the critical speed: more deflection than under a force."""
    speed, mass = 0.5 * W1 * L / np.pi, 0.5 * LINE * L
    solution = fmb.simulate(crossing(speed, mass, FORCE, body), 0.97 * L / speed, samples=101)
    expected = moving_mass(solution.t, speed, mass, FORCE)
    assert np.abs(expected - inglis(solution.t, speed, FORCE)).max() > 0.2 * expected.max()
    np.testing.assert_allclose(-solution["mid"][:, 2], expected, atol=1e-2 * np.abs(expected).max())


def sliding(normal=None):
    """A bead on a free, bent and turning reduced beam; with `normal` it may move across."""
    beam = fmb.FloatingBody(
        "beam", data=reduced(), at=(0, 0, 1), rotation=(0.1, -0.2, 0.3), angular_velocity=(0.2, 0.5, 1.0)
    )
    r = Rotation.from_rotvec((0.1, -0.2, 0.3)).apply((4.5, 0.0, 0.0))
    start = fmb.PointMass("load", mass=200.0, at=r + (0, 0, 1), velocity=np.cross((0.2, 0.5, 1.0), r))
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), beam, start],
        joints=[fmb.PointOnPath("wheel", markers=(PATH[0], "load.center"), through=PATH[1:], normal=normal)],
        forces=[fmb.SpringDamper("rope", markers=("ground.origin", "load.center"), stiffness=2e4, damping=0.0)],
        sensors=[fmb.Position("r", marker="load.center"), fmb.Energy("energy"), fmb.Reaction("force", joint="wheel")],
    )


@pytest.mark.parametrize("normal", [None, "z"])
def test_formulations_and_integrators_agree(normal):
    """The same accelerations, and the same bead after 0.02 s; no energy is made or lost."""
    model = sliding(normal)
    given = fmb.accelerations(model, formulation=fmb.Augmented())
    for formulation in (fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Recursive()):
        found = fmb.accelerations(model, formulation=formulation)
        for body in ("beam", "load"):
            np.testing.assert_allclose(found[body], given[body], atol=1e-7 * np.abs(given["load"]).max())
    ends = {}
    for integrator in (
        fmb.GeneralizedAlpha(rho_inf=0.95, rtol=1e-7),
        fmb.IDA(rtol=1e-8, atol=1e-10),
        fmb.Explicit(rtol=1e-8, atol=1e-10),
    ):
        solution = fmb.simulate(model, 0.02, samples=4, integrator=integrator)
        ends[type(integrator).__name__] = solution["r"][-1]
        assert np.ptp(solution["energy"]) < 1e-3 * np.abs(solution["energy"]).max()
    reference = ends.pop("Explicit")
    for name, place in ends.items():
        np.testing.assert_allclose(place, reference, atol=2e-4, err_msg=name)


def test_a_path_over_two_bodies_and_beyond_its_ends():
    """Through markers of several bodies; beyond its ends the track is straight or an error."""
    bodies = [
        fmb.Ground(markers={"a": (0, 0, 0), "b": (1, 0, 0)}),
        fmb.RigidBody(
            "rail", mass=5.0, inertia=(1, 1, 1), at=(2, 0, 0), markers={"e": (-1, 0, 0), "c": (0, 0, 0), "d": (1, 0, 0)}
        ),
        fmb.PointMass("bead", mass=1.0, at=(0.5, 0, 0), velocity=(2.0, 0, 0)),
    ]
    path = {"markers": ("ground.a", "bead.center"), "through": ("ground.b", "rail.c", "rail.d")}
    for ends in ("extend", "error"):
        model = fmb.Model(
            bodies=bodies,
            joints=[fmb.Fixed("f", markers=("ground.b", "rail.e")), fmb.PointOnPath("p", **path, ends=ends)],
            sensors=[fmb.Position("r", marker="bead.center")],
        )
        if ends == "extend":
            np.testing.assert_allclose(fmb.simulate(model, 2.0, samples=3)["r"][-1], (4.5, 0, 0), atol=1e-6)
        else:
            with pytest.raises(fmb.IntegrationError, match="p: OnPath"):
                fmb.simulate(model, 2.0, samples=201)


@pytest.mark.parametrize(
    ("fields", "found"),
    [
        ({"through": "ground.b"}, "expected: names of markers|names of markers"),
        ({"through": ("ground.b",)}, "a path through 2 markers"),
        ({"through": ("ground.b", "ground.b")}, "meets marker 'ground.b' twice"),
        ({"through": ("ground.a", "ground.b")}, "meets marker 'ground.a' twice"),
        ({"through": ("ground.b", "ground.c"), "ends": "stop"}, "ends = 'stop'"),
        ({"through": ("ground.b", "ground.c"), "normal": "u"}, "normal = 'u'"),
    ],
)
def test_messages(fields, found):
    with pytest.raises(fmb.ModelError, match=found):
        fmb.PointOnPath("p", markers=("ground.a", "b.center"), **fields)


@pytest.mark.parametrize(
    ("through", "found"),
    [
        (("ground.b", "ground.x"), "ground.x"),
        (("ground.b", "bead.m"), "path marker 'bead.m' on body 'bead'"),
        (("ground.b", "ground.twin"), "'ground.b' and 'ground.twin' of the path are at the same place"),
    ],
)
def test_messages_of_the_model(through, found):
    bodies = [
        fmb.Ground(markers={"a": (0, 0, 0), "b": (1, 0, 0), "twin": (1, 0, 0)}),
        fmb.RigidBody("bead", mass=1.0, inertia=(1, 1, 1), at=(0.5, 0, 0), markers={"m": (2, 0, 0)}),
    ]
    path = fmb.PointOnPath("p", markers=("ground.a", "bead.center"), through=through)
    with pytest.raises(fmb.ModelError, match=found):
        fmb.check(fmb.Model(bodies=bodies, joints=[path]))
