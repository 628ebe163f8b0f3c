"""The towing chain against an integration of its own: angles of the links, multipliers eliminated by the null space."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import null_space

import flexmb as fmb
from flexmb.errors import CompileError

CHAIN = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "towing_chain.py"))
L, M, A, G = (CHAIN[name] for name in ("LENGTH", "MASS", "ACCELERATION", "GRAVITY"))


def rates(t, y):
    """Rates of the angles and their speeds (6 + 6), and the force on the end (2,)."""
    angle, speed = y[:6], y[6:]
    along, across = np.array((np.cos(angle), np.sin(angle))), np.array((-np.sin(angle), np.cos(angle)))
    mass, load = np.eye(6) * M * (L**2 + 3.0 * CHAIN["RADIUS"] ** 2) / 12.0, np.zeros(6)
    for k in range(6):
        arm = L * np.where(np.arange(6) < k, 1.0, np.where(np.arange(6) == k, 0.5, 0.0))
        J, bias = across * arm, -along @ (arm * speed**2)
        mass += M * J.T @ J
        load += M * J.T @ (np.array((0.0, -G)) - bias)
    end, wanted = L * across, np.array((A, 0.0)) + L * along @ speed**2
    N, first = null_space(end), np.linalg.pinv(end) @ wanted
    a = first + N @ np.linalg.solve(N.T @ mass @ N, N.T @ (load - mass @ first))
    return np.concatenate([speed, a]), np.linalg.lstsq(end.T, mass @ a - load)[0]


def reference(times, opened, rtol=1e-10):
    """Shapes (nt, 7, 2), m, and the force on the end (nt, 2), N."""
    start = np.concatenate([np.radians([-90.0 + opened] * 3 + [90.0 - opened] * 3), np.zeros(6)])
    found = solve_ivp(
        lambda t, y: rates(t, y)[0], (0, times[-1]), start, method="DOP853", t_eval=times, rtol=rtol, atol=1e-11
    )
    places = np.zeros((len(times), 7, 2))
    places[:, 1:] = L * np.cumsum(np.stack([np.cos(found.y[:6]), np.sin(found.y[:6])], axis=-1), axis=0).transpose(
        1, 0, 2
    )
    return places, np.array([rates(t, y)[1] for t, y in zip(times, found.y.T, strict=True)])


@pytest.fixture(scope="module")
def expected():
    return reference(np.linspace(0.0, CHAIN["DURATION"], 17), CHAIN["OPENED"])


@pytest.mark.parametrize(
    ("integrator", "within"),
    [
        (None, 1e-8),
        (fmb.Explicit(formulation=fmb.UdwadiaPhohomsiri()), 1e-8),
        (fmb.Explicit(formulation=fmb.Recursive()), 1e-8),
        (fmb.GeneralizedAlpha(rtol=1e-8), 2e-5),
        (fmb.IDA(rtol=1e-8), 5e-6),
    ],
    ids=["null space", "Udwadia-Phohomsiri", "recursive", "generalised-alpha", "IDA"],
)
def test_shapes_and_force(expected, integrator, within):
    motion = CHAIN["run"](integrator=integrator)
    places, force = expected
    np.testing.assert_allclose(CHAIN["shapes"](motion), places, atol=within)
    pull = np.column_stack([motion["pull"], motion["lift"]])
    np.testing.assert_allclose(pull, force, atol=10.0 * within * np.abs(force).max())


def test_folded_start_is_named_and_refused():
    folded = CHAIN["chain"](0.0)
    found = fmb.check(folded).singular
    assert (found.instantaneous, found.finite) == (5, 4)
    with pytest.raises(CompileError, match="singular configuration: 5 instantaneous freedoms, 4 of motions"):
        fmb.simulate(folded, 0.1)


def test_arrays_without_multipliers():
    """M, Q, A and b in the rates of the pins against those of the angles: u = T angle', T takes differences."""
    arrays = fmb.equations(CHAIN["chain"]()).in_joint_coordinates()
    assert arrays.M.shape == (6, 6)
    assert arrays.equation_names == ("tow: Formula", "height: Formula")
    start = np.concatenate([np.radians([-89.9] * 3 + [89.9] * 3), np.zeros(6)])
    a = rates(0.0, start)[0][6:]
    N, first = arrays.complement, arrays.A_pinv @ arrays.b
    z = np.linalg.solve(N.T @ arrays.M @ N, N.T @ (arrays.Q - arrays.M @ first))
    np.testing.assert_allclose(first + N @ z, np.diff(a, prepend=0.0), atol=1e-8)
    np.testing.assert_allclose(arrays.A @ N, 0.0, atol=1e-12)


def test_bookkeeping_of_euler_parameters():
    """p = (cos, 0, 0, sin) of half the angle; the block 4 L J L^T with p' = L w, J about the start of the link, rank 3.

    The accelerations without multipliers are those of the pins' rates; of the links in motion too.
    """
    for state in (None, CHAIN["run"]().state(1.0)):
        found = fmb.equations(CHAIN["chain"](), state)
        turned, pins = found.in_euler_parameters(), found.in_joint_coordinates()
        assert turned.M.shape == (42, 42)
        assert np.linalg.matrix_rank(turned.M) == 36
        p, dp, block, row, right = CHAIN["bookkeeping"](turned, "link 2")
        if state is None:
            half = np.radians(-90.0 + CHAIN["OPENED"]) / 2.0
            np.testing.assert_allclose(np.abs(p), np.abs((np.cos(half), 0.0, 0.0, np.sin(half))), atol=1e-12)
        a, b, c, d = p
        E = np.array([[-b, a, d, -c], [-c, -d, a, b], [-d, c, -b, a]])  # w = 2 E p'
        across = M * (L**2 / 3.0 + CHAIN["RADIUS"] ** 2 / 4.0)
        J = np.diag((0.5 * M * CHAIN["RADIUS"] ** 2, across, across))
        np.testing.assert_allclose(block, 4.0 * E.T @ J @ E, atol=1e-12)
        assert np.linalg.matrix_rank(block) == 3
        assert right == pytest.approx(-dp @ dp, abs=1e-12)
        np.testing.assert_allclose(row[row != 0.0], p[p != 0.0])
        u = [CHAIN["without_multipliers"](x) for x in (turned, pins)]
        accelerations = [x.B @ y + x.Bdot_u for x, y in zip((turned, pins), u, strict=True)]
        scale = np.abs(accelerations[1]).max()
        np.testing.assert_allclose(accelerations[0], accelerations[1], atol=1e-9 * scale)
        np.testing.assert_allclose(turned.A @ turned.complement, 0.0, atol=1e-12)
