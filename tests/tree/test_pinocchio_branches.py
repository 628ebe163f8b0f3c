"""A floating base with branches of hinges, slides and balls in Pinocchio:
poses, inverse dynamics, accelerations, energy.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tree.pinocchio_trees import fields_of_body

import flexmb as fmb

KINDS = {
    "turn": ("JointModelRZ", fmb.Revolute),
    "slide": ("JointModelPZ", fmb.Prismatic),
    "ball": ("JointModelSpherical", fmb.Spherical),
    "free": ("JointModelFreeFlyer", None),
}
LIMBS = [
    (0, "free"),
    (1, "turn"),
    (2, "slide"),
    (1, "ball"),
    (4, "turn"),
    (4, "ball"),
    (6, "slide"),
    (1, "turn"),
    (8, "turn"),
]
"""Parent and joint of every body; 0 is the world."""
GRAVITY = (0.3, -0.5, -9.81)


def both(pin, rng):
    """Return the tree in Pinocchio and here: the same placements and inertias."""
    theirs = pin.Model()
    theirs.gravity.linear = np.array(GRAVITY)
    markers = [{} for _ in range(len(LIMBS) + 1)]
    at = [np.eye(4)]
    bodies, joints = [], []
    for k, (parent, kind) in enumerate(LIMBS, 1):
        free = kind == "free"
        seat = (
            pin.SE3.Identity()
            if free
            else pin.SE3(Rotation.from_rotvec(rng.normal(size=3)).as_matrix(), rng.normal(size=3))
        )
        joint = theirs.addJoint(parent, getattr(pin, KINDS[kind][0])(), seat, f"joint_{k}")
        A = rng.normal(size=(3, 3))
        J = A @ A.T + np.eye(3)
        inertia = pin.Inertia(1.0 + rng.uniform(), 0.2 * rng.normal(size=3), 0.1 * (np.trace(J) * np.eye(3) - J))
        theirs.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        at.append(at[parent] @ seat.homogeneous)
        bodies.append(fields_of_body(inertia, at[k]))
        if not free:
            markers[parent][f"to_{k}"] = fmb.Pose(seat.translation, seat.rotation)
            markers[k]["in"] = (0, 0, 0)
            joints.append(KINDS[kind][1](f"joint_{k}", markers=(f"link_{parent}.to_{k}", f"link_{k}.in")))
    links = [
        fmb.RigidBody(f"link_{k}", markers={"end": (0.1, 0.2, 0.3), **markers[k]}, **body)
        for k, body in enumerate(bodies, 1)
    ]
    return theirs, fmb.Model(bodies=[fmb.Ground(), *links], joints=joints, gravity=GRAVITY)


def places(model, tree):
    """Return for every number of Pinocchio's coordinates and rates its place here."""
    q, v = np.zeros(model.nq, int), np.zeros(model.nv, int)
    for k, (_, kind) in enumerate(LIMBS, 1):
        iq, iv = model.idx_qs[k], model.idx_vs[k]
        prefix = f"link_{k}." if kind == "free" else f"joint_{k}."
        here = [n for n, name in enumerate(tree.names) if name.startswith(prefix)]
        rates = [n for n, name in enumerate(tree.rate_names) if name.startswith(prefix)]
        if kind in ("free", "ball"):  # their quaternion has its scalar last
            here = [*here[:-4], *here[-3:], here[-4]]
        q[iq : iq + len(here)], v[iv : iv + len(rates)] = here, rates
    return q, v


@pytest.mark.peer
def test_branches_on_a_floating_base(rng):
    pin = pytest.importorskip("pinocchio")
    model, twin = both(pin, rng)
    tree, data = fmb.JointTree(twin), model.createData()
    iq, iv = places(model, tree)
    for _ in range(3):
        q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
        v, a = rng.normal(size=(2, model.nv))
        ours = [np.zeros(len(numbers)) for numbers in (q, v, v)]
        ours[0][iq], ours[1][iv], ours[2][iv] = q, v, a
        pin.forwardKinematics(model, data, q, v, a)
        pin.computeJointJacobians(model, data, q)
        for k in range(1, model.njoints):
            r, R = tree.pose(f"link_{k}.end", ours[0])
            end = data.oMi[k] * pin.SE3(np.eye(3), np.array([0.1, 0.2, 0.3]))
            np.testing.assert_allclose(r, end.translation, atol=1e-12)
            np.testing.assert_allclose(R, end.rotation, atol=1e-12)
            J = (
                end.toActionMatrixInverse()
                @ data.oMi[k].toActionMatrix()
                @ pin.getJointJacobian(model, data, k, pin.LOCAL)
            )
            expected = np.kron(np.eye(2), end.rotation) @ J
            np.testing.assert_allclose(tree.jacobian(f"link_{k}.end", ours[0])[:, iv], expected, atol=1e-11)
        tau = pin.rnea(model, data, q, v, a)
        np.testing.assert_allclose(tree.torques(*ours)[iv], tau, atol=1e-11 * np.abs(tau).max())
        free = tree.absolute(ours[0], ours[1])
        free.a[:] = fmb.Recursive().accelerate(tree.system, free, tree.system.workspace())[0]
        expected = pin.aba(model, data, q, v, np.zeros(model.nv))
        np.testing.assert_allclose(tree.relative(free).a[iv], expected, atol=1e-10 * np.abs(expected).max())
