"""An own geometrically exact reference: the planar inextensible beam as a chain of rigid links with torsion springs.

Absolute angles theta_i of n uniform links of length h and mass m; springs E I / h between them, 2 E I / h at the
clamped root, which turns by psi(t). The kinetic energy is exact for rigid links, so nothing is linearised; the error is
of second order in h and two chains give an extrapolated value.
"""

import numpy as np
from scipy.integrate import solve_ivp


def spin_up_lag(length, EI, rhoA, psi, rate, times, n, rtol=1e-7):
    """Return the tip's displacement across the direction psi, (nt,), m."""
    h = length / n
    m, k = rhoA * h, EI / h
    after = np.arange(n)[::-1]  # links beyond link i
    order = np.maximum.outer(np.arange(n), np.arange(n))
    moment = m * h**2 * (0.5 + after)[order]  # coefficient of cos(theta_i - theta_j), i != j
    np.fill_diagonal(moment, m * h**2 * (1.0 / 3.0 + after))

    def rates(t, y):
        theta, speed = y[:n], y[n:]
        difference = theta[:, None] - theta[None, :]
        bend = k * np.diff(theta)
        torque = np.append(bend, 0.0) - np.insert(bend, 0, 2.0 * k * (theta[0] - psi(t)))
        right = torque - (moment * np.sin(difference)) @ speed**2
        return np.concatenate([speed, np.linalg.solve(moment * np.cos(difference), right)])

    start = np.concatenate([np.full(n, psi(0.0)), np.full(n, rate(0.0))])
    run = solve_ivp(rates, (0.0, times[-1]), start, method="Radau", t_eval=times, rtol=rtol, atol=1e-9)
    return h * np.sin(run.y[:n] - psi(times)[None, :]).sum(axis=0)


def extrapolated_lag(length, EI, rhoA, psi, rate, times, n):
    """Return the lag extrapolated from chains of n / 2 and n links."""
    coarse, fine = (spin_up_lag(length, EI, rhoA, psi, rate, times, count) for count in (n // 2, n))
    return fine + (fine - coarse) / 3.0
