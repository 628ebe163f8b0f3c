"""Motions in orbit with closed forms: libration by the gradient of gravity, the turning of a node by J2.

References: Hughes 1986, section 9.1 (small motions of a satellite that faces the Earth); Vallado 2013, eq. 9-38 (node).
"""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb import fem, reduction

MU = 3.986004418e14


def test_libration_about_all_three_axes():
    """Roll, pitch and yaw of 1e-4 rad over two orbits; left are squares of the angles.

    J1 f'' + 4 n2 (J2 - J3) f - n (J1 - J2 + J3) y' = 0, J3 y'' + n2 (J2 - J1) y + n (J1 - J2 + J3) f' = 0,
    J2 p'' + 3 n2 (J1 - J3) p = 0: pitch with the frequency n sqrt(3 (J1 - J3) / J2).
    """
    J, angles = np.array((900.0, 1000.0, 300.0)), 1e-4 * np.array((1.0, -0.7, 0.5))
    orbit = fmb.Orbit.circular(7e6, inclination=1.1, node=0.4, argument=0.2)
    n = 2 * np.pi / orbit.period

    def facing(t):
        r, v = orbit.at(t)
        along, nadir = v / np.linalg.norm(v), -r / np.linalg.norm(r)
        return Rotation.from_matrix(np.stack([along, np.cross(nadir, along), nadir], axis=1))

    start = facing(0.0) * Rotation.from_rotvec(angles)
    body = fmb.RigidBody(
        "b", mass=500.0, inertia=tuple(J), rotation=start, angular_velocity=facing(0.0).apply((0, -n, 0))
    )
    model = fmb.Model(
        bodies=[fmb.Ground(), body],
        forces=[fmb.CentralGravity("g", body="b")],
        sensors=[fmb.Orientation("p", marker="b.center")],
        origin=orbit,
    )
    run = fmb.simulate(model, 2 * orbit.period, samples=9)
    found = [
        (facing(t).inv() * Rotation.from_quat(np.roll(p, -1))).as_rotvec() for t, p in zip(run.t, run["p"], strict=True)
    ]
    c = n * (J[0] - J[1] + J[2])
    A = np.zeros((6, 6))
    A[:3, 3:] = np.eye(3)
    A[3, 0], A[3, 5] = -4 * n**2 * (J[1] - J[2]) / J[0], c / J[0]
    A[4, 1] = -3 * n**2 * (J[0] - J[2]) / J[1]
    A[5, 2], A[5, 3] = -(n**2) * (J[1] - J[0]) / J[2], -c / J[2]
    # the body turns with the orbit: the angles against it are constant at first
    expected = [(expm(A * t) @ np.concatenate([angles, np.zeros(3)]))[:3] for t in run.t]
    np.testing.assert_allclose(found, expected, atol=2e-3 * np.abs(expected).max())


def test_libration_of_an_elastic_body():
    """Seven points with stiff springs between them turn as the rigid body of their moments."""
    rng = np.random.default_rng(7)
    nodes, masses = rng.normal(size=(7, 3)), rng.uniform(0.5, 2.0, size=7)
    K = np.zeros((21, 21))
    for i in range(7):
        for j in range(i):
            e = (nodes[i] - nodes[j]) / np.linalg.norm(nodes[i] - nodes[j])
            for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                K[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += sign * 500.0 * np.outer(e, e)
    with pytest.warns(UserWarning, match="speed of sound"):
        fe = fem.from_matrices(K, np.diag(np.repeat(masses, 3)), nodes)
    data = reduction.reduce(fe, interfaces={"a": [0, 1, 2]}, modes=3)
    orbit = fmb.Orbit.circular(5e5, mu=0.05**2 * 5e5**3)
    at = {
        "at": (0.4, 0.1, -0.2),
        "velocity": (0.001, 0, 0),
        "rotation": (0.3, 0.2, -0.1),
        "angular_velocity": (0, 0, 0.05),
    }
    soft = fmb.FloatingBody("b", data=data, geometric_stiffness=False, damping=0.3, **at)
    stiff = fmb.FloatingBody("b", data=data, rigid=True, **at)
    own = {"mass": data.mass, "inertia": data.inertia, "center_of_mass": data.center_of_mass}
    plain = fmb.RigidBody("b", **own, **at, markers={"a": data.marker_positions[0]})
    found = []
    for body in (soft, stiff, plain):
        model = fmb.Model(
            bodies=[fmb.Ground(), body],
            forces=[fmb.CentralGravity("g", body="b", mu=orbit.mu)],
            sensors=[fmb.Position("r", marker="b.a"), fmb.Orientation("p", marker="b.a")],
            origin=orbit,
        )
        run = fmb.simulate(model, 60.0, samples=4, integrator=fmb.Explicit())
        found.append(np.hstack([run["r"], run["p"]]))
    # about a frame beside the centre of mass, terms of third order differ: (size / distance)^3
    np.testing.assert_allclose(found[1], found[2], atol=1e-4)
    np.testing.assert_allclose(found[0], found[2], atol=2e-3)
    assert np.abs(found[2] - found[2][0]).max() > 0.5


def test_node_turns_by_flattening():
    """dO/dt = -3/2 n J2 (R / a)^2 cos i, over three orbits from node to node, relative to a Kepler orbit."""
    a, i, J2, R = 7.2e6, 0.9, 1.0826267e-3, 6378137.0
    orbit = fmb.Orbit.circular(a, inclination=i, node=0.3)
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("b", mass=2.0)],
        forces=[fmb.CentralGravity("g", body="b"), fmb.OblateGravity("j2", body="b")],
        sensors=[fmb.OrbitalPosition("r", marker="b.center"), fmb.OrbitalVelocity("v", marker="b.center")],
        origin=orbit,
    )
    run = fmb.simulate(model, 3 * orbit.period, samples=4)
    h = np.cross(run["r"], run["v"])
    node = np.unwrap(np.arctan2(h[:, 0], -h[:, 1]))
    rate = -1.5 * 2 * np.pi / orbit.period * J2 * (R / a) ** 2 * np.cos(i)
    np.testing.assert_allclose(node - 0.3, rate * run.t, atol=5e-3 * abs(rate * run.t[-1]))
