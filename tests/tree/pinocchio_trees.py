"""Random trees of rigid bodies, the same here and in Pinocchio: hinges, slides, both at once, balls, free bodies."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

import flexmb as fmb

KINDS = {"turn": fmb.Revolute, "slide": fmb.Prismatic, "both": fmb.Cylindrical, "ball": fmb.Spherical, "free": None}


def _joint(pin, kind: str):
    if kind == "both":  # slides first, as `JointTree` counts
        joint = pin.JointModelComposite(pin.JointModelPZ())
        joint.addJoint(pin.JointModelRZ())
        return joint
    names = {"turn": "RZ", "slide": "PZ", "ball": "Spherical", "free": "FreeFlyer"}
    return getattr(pin, f"JointModel{names[kind]}")()


def fields_of_body(inertia, at: np.ndarray) -> dict:
    """Return the fields of a rigid body with Pinocchio's inertia, at a place (4, 4)."""
    return {
        "mass": inertia.mass,
        "inertia": inertia.inertia,
        "center_of_mass": inertia.lever,
        "at": at[:3, 3],
        "rotation": at[:3, :3],
    }


class Twin:
    """A random tree in Pinocchio, `theirs` with `data`, and here, `tree`.

    Lengths are of the size `length` (m), masses of the size `mass` (kg). Joints may be drawn from the body to its
    parent; their coordinates then count backwards. A `floating` tree hangs on its free first body.
    """

    def __init__(self, pin, rng, n: int, length: float = 1.0, mass: float = 1.0, floating: bool = False):
        self.pin, self.theirs = pin, pin.Model()
        gravity = rng.normal(size=3) * 10.0
        self.theirs.gravity.linear = gravity
        self.limbs: list[tuple[str, float]] = []
        markers: list[dict] = [{} for _ in range(n + 1)]
        at, fields, joints = [np.eye(4)], [], []
        for k in range(1, n + 1):
            kind = str(rng.choice(list(KINDS), p=(0.4, 0.2, 0.1, 0.2, 0.1)))
            kind = ("free" if k == 1 else kind.replace("free", "turn")) if floating else kind
            free = KINDS[kind] is None
            parent = 0 if free else int(rng.integers(int(floating), k))
            turn = np.eye(3) if free else Rotation.random(random_state=rng).as_matrix()
            seat = pin.SE3(turn, np.zeros(3) if free else length * rng.normal(size=3))
            joint = self.theirs.addJoint(parent, _joint(pin, kind), seat, f"joint_{k}")
            inertia = self._inertia(rng, length, mass)
            self.theirs.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
            at.append(at[parent] @ seat.homogeneous)
            fields.append(fields_of_body(inertia, at[k]))
            back = kind in ("turn", "slide") and rng.uniform() < 0.4
            self.limbs.append((kind, -1.0 if back else 1.0))
            if free:
                markers[k]["in"] = (0, 0, 0)
            else:
                own = "ground" if parent == 0 else f"link_{parent}"
                markers[parent][f"to_{k}"] = fmb.Pose(seat.translation, seat.rotation)
                markers[k]["in"] = (0, 0, 0)
                pair = (f"{own}.to_{k}", f"link_{k}.in")
                joints.append(KINDS[kind](f"joint_{k}", markers=pair[::-1] if back else pair))
        tool = {"tool": tuple(length * np.array((0.1, 0.2, 0.3)))}
        links = [fmb.RigidBody(f"link_{k}", markers={**tool, **markers[k]}, **own) for k, own in enumerate(fields, 1)]
        # the first body of a floating tree is its root
        order = sorted(rng.permutation(n), key=lambda k: self.limbs[k][0] != "free")
        self.model = fmb.Model(
            bodies=[fmb.Ground(markers=markers[0]), *(links[k] for k in order)], joints=joints, gravity=tuple(gravity)
        )
        self.tree, self.data, self.tool = fmb.JointTree(self.model), self.theirs.createData(), tool["tool"]
        self._places()

    def _inertia(self, rng, length: float, mass: float):
        A = rng.normal(size=(3, 3))
        J = A @ A.T + np.eye(3)
        size = mass * length**2
        return self.pin.Inertia(
            mass * (1.0 + rng.uniform()), 0.2 * length * rng.normal(size=3), 0.1 * size * (np.trace(J) * np.eye(3) - J)
        )

    def _places(self) -> None:
        """Find the place here, and the sign, of every number of Pinocchio's coordinates and rates."""
        self.iq, self.iv = np.zeros(self.theirs.nq, int), np.zeros(self.theirs.nv, int)
        self.sq, self.sv = np.ones(self.theirs.nq), np.ones(self.theirs.nv)
        for k, (kind, sign) in enumerate(self.limbs, 1):
            iq, iv = self.theirs.idx_qs[k], self.theirs.idx_vs[k]
            prefix = f"link_{k}." if kind == "free" else f"joint_{k}."
            here = [n for n, name in enumerate(self.tree.names) if name.startswith(prefix)]
            rates = [n for n, name in enumerate(self.tree.rate_names) if name.startswith(prefix)]
            if kind in ("free", "ball"):  # their quaternion has its scalar last
                here = [*here[:-4], *here[-3:], here[-4]]
            self.iq[iq : iq + len(here)], self.iv[iv : iv + len(rates)] = here, rates
            self.sq[iq : iq + len(here)], self.sv[iv : iv + len(rates)] = sign, sign

    def coordinates(self, q: np.ndarray) -> np.ndarray:
        """Return the coordinates here of Pinocchio's q."""
        out = np.zeros(len(q))
        out[self.iq] = self.sq * q
        return out

    def rates(self, v: np.ndarray) -> np.ndarray:
        """Return rates, or forces on them, here of Pinocchio's."""
        out = np.zeros(len(v))
        out[self.iv] = self.sv * v
        return out

    def state(self, rng, length: float = 1.0) -> tuple[np.ndarray, ...]:
        """Return Pinocchio's q, and four vectors of the size of its rates; translations are of the size `length`."""
        pin, nv = self.pin, self.theirs.nv
        size = np.ones(nv)
        for k, (kind, _) in enumerate(self.limbs, 1):
            at = self.theirs.idx_vs[k]
            if kind in ("slide", "both"):
                size[at] = length
            elif kind == "free":
                size[at : at + 3] = length
        q = pin.integrate(self.theirs, pin.neutral(self.theirs), size * rng.normal(size=nv))
        return q, size * rng.normal(size=nv), size * rng.normal(size=nv), rng.normal(size=nv) / size
