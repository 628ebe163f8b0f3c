"""The unreduced FE model of a rod, carried through the motion of a mechanism: an own integration for comparison.

The planar freedoms u of all nodes are measured in a frame at the pin A that turns with the *rigid* mechanism, so its
motion is given. The material at x has the place r = (x, 0) + N(x) u in it, with the interpolation N of the elements
(linear along, cubic across), and the velocity v + w J r + N u', J a quarter turn. Lagrange's equations are linear in
u, with S = int N^T J N dm and C = int N^T N dm::

    M u'' + 2 w S u' + (K + w' S - w^2 C) u
        = -int N^T (v' + w J v + w' J x - w^2 x) dm - w' (moments of rotary inertia) + A^T lam_A + (dg/du)^T lam_B

J N is integrated as it is: turned nodal vectors interpolated anew would be linear across too, and a uniform motion
seen from the turning frame would have forces.

Pin A is held, pin B carries a point mass on a curve g(x_B) = 0 in the plane: a slider on y = 0, or a rocker on its
circle.
"""

import numpy as np


class FullRod:
    """The rod as all its FE freedoms.

    Parameters
    ----------
    fe : FEModel
        A frame along x from pin A at the origin to pin B.
    density : float, kg/m
        Of the rod.
    end_mass : float, kg
        Of the slider, or J / c^2 of a rocker of the length c.
    place : function t -> (x_A (2,), phi), with the rod's rigid angle
    curve : function x (2,) -> (g, dg/dx (2,), d2g/dx2 (2, 2))
    """

    def __init__(self, fe, density, end_mass, place, curve, damping=0.0):
        planar = np.flatnonzero(np.isin(fe.dofs[:, 1], (0, 1, 5)))
        dofs = fe.dofs[planar]
        self.fe, self.planar, self.place, self.curve = fe, planar, place, curve
        self.end_mass, self.damping = end_mass, damping
        self.K, self.M = (matrix[planar][:, planar].toarray() for matrix in (fe.K, fe.M))
        last = int(np.argmax(fe.nodes[:, 0]))
        self.A, self.B = (
            np.array([np.flatnonzero((dofs == (n, d)).all(axis=1))[0] for d in (0, 1)])
            for n in (int(np.argmin(fe.nodes[:, 0])), last)
        )
        self.M[self.B, self.B] += end_mass
        self.length = fe.nodes[last, 0]
        self._integrate(dofs, density)
        self.C[self.B, self.B] += end_mass
        self.S[self.B[0], self.B[1]] -= end_mass
        self.S[self.B[1], self.B[0]] += end_mass
        self.first[self.B] += end_mass * np.eye(2)
        self.second[self.B[0]] += end_mass * self.length
        # M times the rigid turn has what rotary inertia adds to the angular acceleration
        turn = np.where(dofs[:, 1] == 1, fe.nodes[dofs[:, 0], 0], np.where(dofs[:, 1] == 5, 1.0, 0.0))
        self.swing = self.M @ turn

    def _integrate(self, dofs, density):
        """Make C, S, int N^T dm (n, 2) and int N^T x e_x dm (n,) by Gauss's rule."""
        n = len(dofs)
        self.C, self.S, self.first, self.second = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, 2)), np.zeros(n)
        row = {(node, direction): k for k, (node, direction) in enumerate(dofs.tolist())}
        order = np.argsort(self.fe.nodes[:, 0])
        points, weights = np.polynomial.legendre.leggauss(4)
        for a, b in zip(order[:-1].tolist(), order[1:].tolist()):
            x0, h = self.fe.nodes[a, 0], self.fe.nodes[b, 0] - self.fe.nodes[a, 0]
            for s, weight in zip((points + 1) / 2, weights / 2):
                N, dm = np.zeros((2, n)), density * h * weight
                N[0, row[a, 0]], N[0, row[b, 0]] = 1 - s, s
                N[1, row[a, 1]], N[1, row[b, 1]] = 1 - 3 * s**2 + 2 * s**3, 3 * s**2 - 2 * s**3
                N[1, row[a, 5]], N[1, row[b, 5]] = h * s * (1 - s) ** 2, h * s**2 * (s - 1)
                self.C += dm * N.T @ N
                self.S += dm * (np.outer(N[1], N[0]) - np.outer(N[0], N[1]))
                self.first += dm * N.T
                self.second += dm * (x0 + s * h) * N[0]

    def frame(self, t, h=1e-6):
        """Return rotation (2, 2), v and v' (2,) in body axes, w, w' by central differences of the given motion."""
        (x0, p0), (x1, p1), (x2, p2) = (self.place(t + k * h) for k in (-1, 0, 1))
        R = np.array([[np.cos(p1), -np.sin(p1)], [np.sin(p1), np.cos(p1)]])
        w, alpha = (p2 - p0) / (2 * h), (p2 - 2 * p1 + p0) / h**2
        v = R.T @ (x2 - x0) / (2 * h)
        rate = R.T @ (x2 - 2 * x1 + x0) / h**2 - w * np.array([-v[1], v[0]])
        return x1, R, v, rate, w, alpha

    def equations(self, t, u):
        """Return C, K_t, f of M u'' + C u' + K_t u = f + G^T lam, the constraints (3,) and their G (3, n),
        curvature.
        """
        x, R, v, rate, w, alpha = self.frame(t)
        C = 2 * w * self.S + self.damping * self.K
        K = self.K + alpha * self.S - w**2 * self.C
        f = -self.first @ (rate + w * np.array([-v[1], v[0]])) - alpha * self.swing + w**2 * self.second
        g, gradient, bend = self.curve(x + R @ (np.array([self.length, 0.0]) + u[self.B]))
        G = np.zeros((3, len(u)))
        G[0, self.A[0]] = G[1, self.A[1]] = 1.0
        G[2, self.B] = gradient @ R
        curvature = np.zeros((len(u), len(u)))
        curvature[np.ix_(self.B, self.B)] = R.T @ bend @ R
        return C, K, f, np.array([*u[self.A], g]), G, curvature, R

    def run(self, t_end, steps, rho=0.9):
        """Return times (nt,), u (nt, n), world forces of the pins on the rod (nt, 2) each, from rest in the frame."""
        n, h = len(self.planar), t_end / steps
        am, af = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
        gamma = 0.5 - am + af
        beta = 0.25 * (gamma + 0.5) ** 2
        u, rate, acc, alg, lam = (np.zeros(n) for _ in range(5))
        lam = np.zeros(3)
        C, K, f, _, G, _, _ = self.equations(0.0, u)
        # the start: hidden constraints of acceleration by finite differences of G
        drift = self._drift(0.0, u)
        left = np.block([[self.M, -G.T], [G, np.zeros((3, 3))]])
        start = np.linalg.solve(left, np.concatenate([f, -drift]))
        acc = alg = start[:n]
        lam = start[n:]
        kept = [(0.0, u, self._pins(0.0, u, acc, rate, lam))]
        for k in range(steps):
            t = (k + 1) * h
            u1 = u + h * rate + h * h * ((0.5 - beta) * alg)
            r1 = rate + h * (1 - gamma) * alg
            a1 = acc.copy()
            g1 = ((1 - af) * a1 + af * acc - am * alg) / (1 - am)
            u1, r1 = u1 + h * h * beta * g1, r1 + h * gamma * g1
            for _ in range(3):
                C, K, f, g, G, curvature, _ = self.equations(t, u1)
                residual = self.M @ a1 + C @ r1 + K @ u1 - f - G.T @ lam
                scale = h * h * beta * (1 - af) / (1 - am)
                S = self.M + scale * (gamma / (beta * h) * C + K - lam[2] * curvature)
                right = np.concatenate([-scale * residual, -g])
                d = np.linalg.solve(np.block([[S, -G.T], [G, np.zeros((3, 3))]]), right)
                u1 = u1 + d[:n]
                r1 = r1 + gamma / (beta * h) * d[:n]
                g1 = g1 + d[:n] / (beta * h * h)
                a1 = a1 + d[:n] / scale
                lam = lam + d[n:] / scale
            u, rate, acc, alg = u1, r1, a1, g1
            kept.append((t, u, self._pins(t, u, acc, rate, lam)))
        times, fields, pins = zip(*kept)
        return np.array(times), np.array(fields), np.array(pins)[:, 0], np.array(pins)[:, 1]

    def _drift(self, t, u, h=1e-5):
        """d2g/dt2 at fixed u, for the curve; pin A has none."""
        values = [self.equations(t + k * h, u)[3][2] for k in (-1, 0, 1)]
        return np.array([0.0, 0.0, (values[0] - 2 * values[1] + values[2]) / h**2])

    def _pins(self, t, u, acc, rate, lam):
        """Forces on the rod in W: of pin A, and of pin B without what the end's own mass takes."""
        x, R, v, dv, w, alpha = self.frame(t)
        p = np.array([self.length, 0.0]) + u[self.B]
        turned = lambda a: np.array([-a[1], a[0]])  # noqa: E731
        end = R @ (dv + w * turned(v) + alpha * turned(p) - w**2 * p + 2 * w * turned(rate[self.B]) + acc[self.B])
        _, gradient, _ = self.curve(x + R @ p)
        return R @ lam[:2], lam[2] * gradient - self.end_mass * end

    def field(self, u):
        """Return planar freedoms (n, k) as the nodal field (nodes, 6, k)."""
        vectors = np.zeros((self.fe.ndof, u.shape[1]))
        vectors[self.planar] = u
        return self.fe.field(vectors)
