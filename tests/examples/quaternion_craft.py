"""Rates of bodies in quaternions with singular mass matrices, compiled: the equations of `test_spacecraft`, by hand.

Gradients and second derivatives of the constraints in closed form: R(p) is quadratic in the Euler parameters, so that
R'' = 2 T(p', p') at p'' = 0.
"""

import numba
import numpy as np


@numba.njit
def bilinear(T, p, q):
    """Sum of p_i q_j (T[i, j] + T[j, i]) / 2, (3, 3)."""
    R = np.zeros((3, 3))
    for i in range(4):
        for j in range(4):
            x = 0.5 * (p[i] * q[j] + p[j] * q[i])
            if x != 0.0:
                for a in range(3):
                    for b in range(3):
                        R[a, b] += x * T[i, j, a, b]
    return R


@numba.njit
def rates(t, y, T, m, J, ends, levers, free, law, rod, rod_length, hinge, orbit, stabilised):
    """Rates of (r, p) and their rates; T (4, 4, 3, 3) makes R, law is (stiffness, cubic, damping), orbit (mu, R, n)."""
    n = len(m)
    size = 7 * n
    q, dq = y[:size].reshape(n, 7), y[size:].reshape(n, 7)
    R, dR, ddR = np.empty((n, 3, 3)), np.empty((n, 3, 3)), np.empty((n, 3, 3))
    slope, E, dE = np.empty((n, 4, 3, 3)), np.empty((n, 3, 4)), np.empty((n, 3, 4))
    w, v, r = np.empty((n, 3)), dq[:, :3].copy(), q[:, :3].copy()
    unit = np.eye(4)
    for k in range(n):
        p, dp = q[k, 3:].copy(), dq[k, 3:].copy()
        R[k] = bilinear(T, p, p)
        dR[k] = 2.0 * bilinear(T, p, dp)
        ddR[k] = 2.0 * bilinear(T, dp, dp)
        for i in range(4):
            slope[k, i] = 2.0 * bilinear(T, unit[i], p)
        for X, x in ((E, p), (dE, dp)):
            X[k, 0] = np.array((-x[1], x[0], x[3], -x[2]))
            X[k, 1] = np.array((-x[2], -x[3], x[0], x[1]))
            X[k, 2] = np.array((-x[3], x[2], -x[1], x[0]))
        w[k] = 2.0 * E[k] @ dp
    # loads
    mu, radius, pace = orbit
    s = -radius * np.array((np.cos(pace * t), np.sin(pace * t), 0.0))
    F, torque = np.empty((n, 3)), np.empty((n, 3))
    for k in range(n):
        x = r[k] - s
        far = np.sqrt(x @ x)
        own = R[k].T @ (x / far)
        Je = J[k] * own
        # x / far^3 + s / radius^3 without cancellation, far^2 = radius^2 (1 + grown)
        grown = (r[k] @ r[k] - 2.0 * (r[k] @ s)) / radius**2
        F[k] = -mu * m[k] * (r[k] / far**3 - s / radius**3 * np.expm1(-1.5 * np.log1p(grown)))
        F[k] -= 1.5 * mu / far**4 * (R[k] @ (J[k].sum() * own + 2.0 * Je - 5.0 * (own @ Je) * own))
        torque[k] = 3.0 * mu / far**3 * np.cross(own, Je)
    for i in range(len(free)):
        a, b = ends[i]
        d = r[b] + R[b] @ levers[i, 1] - r[a] - R[a] @ levers[i, 0]
        speed = v[b] + R[b] @ np.cross(w[b], levers[i, 1]) - v[a] - R[a] @ np.cross(w[a], levers[i, 0])
        length = np.sqrt(d @ d)
        x = length - free[i]
        pull = ((law[0] + law[1] * x * x) * x + law[2] * (d @ speed) / length) / length * d
        F[a] += pull
        F[b] -= pull
        torque[a] += np.cross(levers[i, 0], R[a].T @ pull)
        torque[b] -= np.cross(levers[i, 1], R[b].T @ pull)
    # constraints: unit norms, the rod twice, the hinge
    ng = n + 2 + (5 if n == 3 else 0)
    g, A, second = np.zeros(ng), np.zeros((ng, size)), np.zeros(ng)
    for k in range(n):
        p, dp = q[k, 3:], dq[k, 3:]
        g[k], second[k] = (p * p).sum() - 1.0, 2.0 * (dp * dp).sum()
        A[k, 7 * k + 3 : 7 * k + 7] = 2.0 * p
    d = r[1] + R[1] @ rod[1] - r[0] - R[0] @ rod[0]
    rate = v[1] + dR[1] @ rod[1] - v[0] - dR[0] @ rod[0]
    bend = ddR[1] @ rod[1] - ddR[0] @ rod[0]
    for k, sign in ((0, -1.0), (1, 1.0)):
        A[n, 7 * k : 7 * k + 3] = 2.0 * sign * d
        for i in range(4):
            A[n, 7 * k + 3 + i] = 2.0 * sign * (d @ (slope[k, i] @ rod[k]))
    g[n], second[n] = d @ d - rod_length**2, 2.0 * (rate @ rate) + 2.0 * (d @ bend)
    A[n + 1], g[n + 1], second[n + 1] = 3.0 * A[n], 3.0 * g[n], 3.0 * second[n]
    if n == 3:
        h = n + 2
        g[h : h + 3] = r[2] + R[2] @ hinge[1] - r[0] - R[0] @ hinge[0]
        second[h : h + 3] = ddR[2] @ hinge[1] - ddR[0] @ hinge[0]
        for k, lever, sign in ((0, hinge[0], -1.0), (2, hinge[1], 1.0)):
            for i in range(3):
                A[h + i, 7 * k + i] = sign
            for i in range(4):
                A[h : h + 3, 7 * k + 3 + i] = sign * (slope[k, i] @ lever)
        for c in range(2):
            row = h + 3 + c
            g[row] = (R[0][:, c] * R[2][:, 2]).sum()
            second[row] = (ddR[0][:, c] * R[2][:, 2] + R[0][:, c] * ddR[2][:, 2]).sum()
            second[row] += 2.0 * (dR[0][:, c] * dR[2][:, 2]).sum()
            for i in range(4):
                A[row, 3 + i] = (slope[0, i][:, c] * R[2][:, 2]).sum()
                A[row, 17 + i] = (R[0][:, c] * slope[2, i][:, 2]).sum()
    b = -second - 2.0 * stabilised * (A @ y[size:]) - stabilised**2 * g
    M, right = A.T @ A, np.empty((size, 1 + ng))
    right[:, 0], right[:, 1:] = A.T @ b, A.T
    for k in range(n):
        i = 7 * k
        for c in range(3):
            M[i + c, i + c] += m[k]
        M[i + 3 : i + 7, i + 3 : i + 7] += 4.0 * E[k].T @ (J[k].reshape(3, 1) * E[k])
        right[i : i + 3, 0] += F[k]
        spin = 2.0 * E[k].T @ torque[k] - 8.0 * dE[k].T @ (J[k] * (E[k] @ dq[k, 3:]))
        right[i + 3 : i + 7, 0] += spin
    solved = np.linalg.solve(M, right)
    multipliers = np.linalg.lstsq(A @ solved[:, 1:], b - A @ solved[:, 0], 1e-11)[0]
    out = np.empty(2 * size)
    out[:size] = y[size:]
    out[size:] = solved[:, 0] + solved[:, 1:] @ multipliers
    return out
