"""The spacecraft against an integration of its own: quaternions, singular mass matrices, doubled constraints, by scipy.

Equations of Schutte & Udwadia, Journal of Applied Mechanics 78 (2011) 021018: seven coordinates of each body, (r, p),
with the mass matrix diag(m, m, m, 4 E^T J E), whose rank is six, and the unit norm as one more constraint. Constraints
are stabilised by Baumgarte's method; their gradients are by complex steps, their second derivatives along the motion by
a difference formula that is exact for polynomials of degree five.
"""

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from examples.quaternion_craft import rates as rates_of_craft
from scipy.integrate import solve_ivp

import flexmb as fmb
from flexmb.errors import CompileError

CRAFT = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "spacecraft.py"))
SECOND = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / 12.0  # of f'' at steps of one
AFTER, BEFORE = [1, 2, 0], [2, 0, 1]
RATE = 0.5  # 1/s, of Baumgarte's method
# R = sum of p_i p_j TURN[i, j], as (16, 9)
QUADRATIC = {
    (0, 0): {(0, 0): 1, (1, 1): 1, (2, 2): -1, (3, 3): -1},
    (1, 1): {(0, 0): 1, (1, 1): -1, (2, 2): 1, (3, 3): -1},
    (2, 2): {(0, 0): 1, (1, 1): -1, (2, 2): -1, (3, 3): 1},
    (0, 1): {(1, 2): 2, (0, 3): -2},
    (1, 0): {(1, 2): 2, (0, 3): 2},
    (0, 2): {(1, 3): 2, (0, 2): 2},
    (2, 0): {(1, 3): 2, (0, 2): -2},
    (1, 2): {(2, 3): 2, (0, 1): -2},
    (2, 1): {(2, 3): 2, (0, 1): 2},
}
TURN = np.zeros((16, 9))
for (row, column), terms in QUADRATIC.items():
    for (i, j), factor in terms.items():
        TURN[4 * i + j, 3 * row + column] = factor


def matrices(p):
    """Rotation matrices of quaternions (..., 4), polynomials of degree two."""
    return ((p[..., :, None] * p[..., None, :]).reshape(*p.shape[:-1], 16) @ TURN).reshape(*p.shape[:-1], 3, 3)


def cross(a, b):
    """Cross products (..., 3), faster than numpy's for a few of them."""
    return a[..., AFTER] * b[..., BEFORE] - a[..., BEFORE] * b[..., AFTER]


def rates(p):
    """E (n, 3, 4) with w = 2 E p' in the axes of the body."""
    a, b, c, d = p.T
    return np.array([[-b, a, d, -c], [-c, -d, a, b], [-d, c, -b, a]]).transpose(2, 0, 1)


class Quaternions:
    """Equations of motion of the spacecraft's first bodies."""

    def __init__(self, panel=True):
        self.names = names = list(CRAFT["BODIES"]) if panel else ["bus", "module"]
        self.panel, self.n = panel, len(names)
        self.m = np.array([CRAFT["BODIES"][name][0] for name in names])
        self.J = np.array([CRAFT["BODIES"][name][1] for name in names])
        springs = [(ends, k) for k, (ends, _) in enumerate(CRAFT["SPRINGS"]) if panel or "panel" not in str(ends)]
        self.length = np.array([CRAFT["lengths"]()[k] for _, k in springs])
        self.ends = np.array([[names.index(end.split(".")[0]) for end in ends] for ends, _ in springs])
        self.levers = np.array([[self.point(end) for end in ends] for ends, _ in springs])
        self.rod = self.point("bus.rod"), self.point("module.rod")
        self.hinge = self.point("bus.hinge"), self.point("panel.hinge")

    @staticmethod
    def point(marker):
        body, name = marker.split(".")
        return np.array(CRAFT["POINTS"][body][name])

    def start(self):
        r = np.array([CRAFT["BODIES"][name][2] for name in self.names]) - CRAFT["center_of_mass"](self.names)
        p = np.tile((1.0, 0.0, 0.0, 0.0), (self.n, 1))
        turn = CRAFT["TURN"]
        dp = np.tile(0.5 * np.concatenate([[0.0], turn]), (self.n, 1))
        return np.concatenate([np.hstack([r, p]).ravel(), np.hstack([np.cross(turn, r), dp]).ravel()])

    def open(self, q):
        """Residuals (k, ng) of states q (k, 7 n): unit norms, the rod twice, the hinge."""
        q = q.reshape(len(q), self.n, 7)
        r, R = q[..., :3], matrices(q[..., 3:])
        d = r[:, 1] + R[:, 1] @ self.rod[1] - r[:, 0] - R[:, 0] @ self.rod[0]
        rod = (d * d).sum(1)[:, None] - CRAFT["ROD"] ** 2
        found = [(q[..., 3:] ** 2).sum(2) - 1.0, rod, 3.0 * rod]
        if self.panel:
            found.append(r[:, 2] + R[:, 2] @ self.hinge[1] - r[:, 0] - R[:, 0] @ self.hinge[0])
            found.append((R[:, 0, :, :2] * R[:, 2, :, 2:]).sum(1))
        return np.concatenate(found, axis=1)

    def loads(self, t, r, R, v, w):
        """Forces (n, 3) in the axes that fall, torques (n, 3) in those of the bodies."""
        angle = CRAFT["MEAN_MOTION"] * t
        s = -CRAFT["RADIUS"] * np.array((np.cos(angle), np.sin(angle), 0.0))
        mu, x = CRAFT["MU"], r - s
        far = np.sqrt((x * x).sum(1))[:, None]
        own = np.einsum("nji,nj->ni", R, x / far)
        Je = self.J * own
        e_J_e = (own * Je).sum(1)[:, None]
        pull = -mu * self.m[:, None] * (x / far**3 + s / CRAFT["RADIUS"] ** 3)
        uneven = self.J.sum(1)[:, None] * own + 2.0 * Je - 5.0 * e_J_e * own
        pull -= 1.5 * mu / far**4 * np.einsum("nij,nj->ni", R, uneven)
        torque = 3.0 * mu / far**3 * cross(own, Je)
        a, b = self.ends.T
        d = r[b] - r[a] + np.einsum("sij,sj->si", R[b], self.levers[:, 1])
        d -= np.einsum("sij,sj->si", R[a], self.levers[:, 0])
        length = np.sqrt((d * d).sum(1))
        x = length - self.length
        speed = v[b] - v[a] + np.einsum("sij,sj->si", R[b], cross(w[b], self.levers[:, 1]))
        speed -= np.einsum("sij,sj->si", R[a], cross(w[a], self.levers[:, 0]))
        lengthening = (d * speed).sum(1) / length
        tension = (CRAFT["STIFFNESS"] + CRAFT["CUBIC"] * x**2) * x + CRAFT["DAMPING"] * lengthening
        F = (tension / length)[:, None] * d
        for end, bodies, sign in ((0, a, 1.0), (1, b, -1.0)):
            on = (bodies == np.arange(self.n)[:, None]) * sign
            pull += on @ F
            torque += on @ cross(self.levers[:, end], np.einsum("sji,sj->si", R[bodies], F))
        return pull, torque

    def __call__(self, t, y):
        """Rates: the explicit equation with M + A^T A, regular as [M; A] has full rank, and a generalised inverse."""
        size, n = 7 * self.n, self.n
        q, dq = y[:size], y[size:]
        h = 1e-30
        A = self.open(q + 1j * h * np.eye(size)).imag.T / h
        along = self.open(q + np.outer(np.arange(-2.0, 3.0), dq))
        b = -SECOND @ along - 2.0 * RATE * A @ dq - RATE**2 * along[2]
        state, rate = q.reshape(n, 7), dq.reshape(n, 7)
        E, dE = rates(state[:, 3:]), rates(rate[:, 3:])
        w = 2.0 * np.einsum("nij,nj->ni", E, rate[:, 3:])
        pull, torque = self.loads(t, state[:, :3], matrices(state[:, 3:]), rate[:, :3], w)
        M = A.T @ A
        Q = A.T @ b
        for k in range(n):
            i = 7 * k
            M[[i, i + 1, i + 2], [i, i + 1, i + 2]] += self.m[k]
            M[i + 3 : i + 7, i + 3 : i + 7] += 4.0 * (E[k].T * self.J[k]) @ E[k]
            Q[i : i + 3] += pull[k]
            Q[i + 3 : i + 7] += 2.0 * E[k].T @ torque[k] - 8.0 * dE[k].T @ (self.J[k] * (E[k] @ rate[k, 3:]))
        solved = np.linalg.solve(M, np.column_stack([Q, A.T]))
        multipliers = np.linalg.lstsq(A @ solved[:, 1:], b - A @ solved[:, 0], rcond=1e-11)[0]
        return np.concatenate([dq, solved[:, 0] + solved[:, 1:] @ multipliers])


def reference(times, panel=True, rtol=1e-9):
    """Places of the bodies by name, (nt, 3), m."""
    equations = Quaternions(panel)
    found = solve_ivp(
        equations, (0.0, times[-1]), equations.start(), method="DOP853", t_eval=times, rtol=rtol, atol=0.1 * rtol
    )
    states = found.y[: 7 * equations.n].T.reshape(len(times), equations.n, 7)
    return {name: states[:, k, :3] for k, name in enumerate(equations.names)}


def compiled(equations):
    """The same rates, compiled: for many orbits."""
    law, orbit = (
        np.array([CRAFT[name] for name in names])
        for names in (("STIFFNESS", "CUBIC", "DAMPING"), ("MU", "RADIUS", "MEAN_MOTION"))
    )
    e, T = equations, np.ascontiguousarray(TURN.reshape(4, 4, 3, 3))
    known = (
        T,
        e.m,
        e.J,
        e.ends,
        e.levers,
        e.length,
        law,
        np.array(e.rod),
        CRAFT["ROD"],
        np.array(e.hinge),
        orbit,
        RATE,
    )
    return lambda t, y: rates_of_craft(t, y, *known)


def reference_over(times, rtol=1e-12):
    """Places of the bodies by name over many orbits."""
    equations = Quaternions()
    of = compiled(equations)
    y = equations.start()
    rng = np.random.default_rng(1)
    for beside in (y, y + 1e-3 * rng.normal(size=len(y))):
        np.testing.assert_allclose(of(9.0, beside), equations(9.0, beside), rtol=0, atol=1e-12)
    found = solve_ivp(of, (0.0, times[-1]), y, method="DOP853", t_eval=times, rtol=rtol, atol=0.1 * rtol)
    states = found.y[: 7 * equations.n].T.reshape(len(times), equations.n, 7)
    return {name: states[:, k, :3] for k, name in enumerate(equations.names)}


def apart(motion, expected):
    """Largest error of the places of bodies relative to the bus, m."""
    return max(np.abs(motion[n] - motion["bus"] - expected[n] + expected["bus"]).max() for n in expected)


@pytest.mark.parametrize("panel", [False, True])
def test_part_of_an_orbit(panel):
    """One minute, without and with the appended panel, the length of the rod given three times."""
    motion, _ = CRAFT["run"](0.01, samples=4, panel=panel)
    assert apart(motion, reference(motion.t, panel)) < 1e-9
    energy, turning = CRAFT["balance"](motion)
    assert energy < 1e-9 * motion["energy"][0]
    assert turning < 1e-3 * np.linalg.norm(motion["momentum"][0, 3:])
    assert motion["open"].max() < 1e-9
    assert len(motion.shared_reactions) == 3


def test_constraints_that_only_look_inconsistent():
    """The same length once or three times: the same accelerations; a length that differs is refused by name."""
    model = CRAFT["spacecraft"]()
    dependent = [joint for joint in model.joints if not joint.name.startswith("the same")]
    once, often = fmb.accelerations(replace(model, joints=dependent)), fmb.accelerations(model)
    for name in CRAFT["BODIES"]:
        np.testing.assert_allclose(once[name], often[name], atol=1e-12)
    over = [fmb.Distance("d", markers=("bus.rod", "module.rod"))]
    other = fmb.Constraint("longer", over=over, equation="d = L", parameters={"L": 1.01})
    with pytest.raises(CompileError, match=r"longer|rod"):
        fmb.simulate(replace(model, joints=[*model.joints, other]), 1.0, integrator=fmb.Explicit())


@pytest.mark.slow
def test_ten_orbits():
    """Balances, constraints and places relative to the bus over ten orbits, at default tolerances.

    Places: within 1e-6 of the separation of the integration in quaternions over all ten orbits and within 1e-8 over the
    first three (reached: 2.6e-7 m and 5e-11 m), and within 1e-6 of a run with a hundredth of the tolerances (1.1e-8 m).
    """
    motion, seconds = CRAFT["run"](10, samples=41)
    print(f"{seconds:.2f} s for an orbit")
    expected = reference_over(motion.t)
    assert apart({name: motion[name][:13] for name in expected}, {n: x[:13] for n, x in expected.items()}) < 1e-8 * 1.8
    assert apart(motion, expected) < 1e-6 * 1.8
    closer, _ = CRAFT["run"](10, samples=41, integrator=fmb.Explicit(rtol=1e-13, atol=1e-14, drift=1e-13))
    assert apart(motion, {name: closer[name] for name in expected}) < 1e-6 * 1.8
    energy, turning = CRAFT["balance"](motion)
    assert energy < 1e-8 * motion["energy"][0]
    assert turning < 0.01 * np.linalg.norm(motion["momentum"][0, 3:])
    assert motion["open"].max() < 1e-9
