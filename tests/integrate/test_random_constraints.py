"""Random models with one to eight constraints of all kinds, dependent ones among them: formulations agree.

Reference: the formulations share no solver (sparse factors, null space, pseudo-inverse, recursion); Udwadia and
Phohomsiri's equation in Euler-parameter rates is solved from the matrices themselves.
"""

from dataclasses import replace

import numpy as np
import pytest
from contracts.random_models import beam
from scipy.linalg import null_space

import flexmb as fmb

FORMULATIONS = (fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Recursive(), fmb.Baumgarte())


def random_model(rng, count: int, elastic: bool = False) -> fmb.Model:
    """Three bodies, two of them on a ball, and constraints between random markers; perhaps the third is elastic."""
    places = rng.normal(size=(3, 3))
    bodies = [fmb.Ground(markers={"o": tuple(rng.normal(size=3))})]
    ends = {}
    for k, at in enumerate(places):
        end = rng.normal(size=3) * 0.5
        J = rng.uniform(0.2, 0.3, size=3)
        moving = {"velocity": rng.normal(size=3), "angular_velocity": rng.normal(size=3)}
        markers = {"s": (0, 0, 0), "e": tuple(end), "ball": tuple(places[1] - at if k < 2 else (0, 0, 0))}
        ends[f"b{k}.e"] = at + end
        if elastic and k == 2:
            bodies.append(fmb.FloatingBody("b2", data=beam(), at=at, geometric_stiffness=False, **moving))
            ends["b2.tip"] = at + beam().marker_positions[beam().marker_names.index("tip")]
            continue
        bodies.append(fmb.RigidBody(f"b{k}", mass=rng.uniform(0.5, 2), inertia=J, at=at, markers=markers, **moving))
    joints = [fmb.Spherical("ball", markers=("b0.ball", "b1.ball"))]
    origin = np.array(bodies[0].markers["o"].at)
    for k in range(count):
        one, two = rng.permutation(3)[:2]
        a, b = ("b2.tip" if elastic and n == 2 else f"b{n}.e" for n in (one, two))
        over = [
            fmb.Distance("d", markers=("ground.o", a)),
            fmb.Distance("f", markers=(a, b)),
            fmb.Velocity("v", marker=a, axes=b),
            fmb.AngularVelocity("w", marker=b),
        ]
        numbers = {
            "D": float(np.linalg.norm(ends[a] - origin)),
            "F": float(np.linalg.norm(ends[a] - ends[b])),
            "x": rng.normal(),
            "y": rng.normal(),
        }
        kind = k % 4
        equation = (
            "f**2 = F**2",
            "d = D + 0.1*sin(2*t)",
            "v[0] + x*w[1] + y*rate(f) = 0.1*t",
            "v[1]*w[2] + x*v[2] = y",
        )[kind]
        forces = {"v[2]": "-x**2*v[2]"} if kind == 2 else {}
        joints.append(fmb.Constraint(f"c{k}", over=over, equation=equation, parameters=numbers, forces=forces))
    left, _, right = equation.partition(" = ")
    again = fmb.Constraint("again", over=over, equation=f"3*({left}) = 3*({right})", parameters=numbers)
    return fmb.Model(bodies=bodies, joints=[*joints, again], gravity=(0, 0, -9.81))


@pytest.mark.parametrize("elastic", [False, True], ids=["rigid", "elastic"])
@pytest.mark.parametrize("count", [1, 2, 4, 8, *(pytest.param(k, marks=pytest.mark.slow) for k in (3, 5, 6, 7))])
def test_formulations_agree(count, elastic):
    model = random_model(np.random.default_rng(40 + count), count, elastic)
    report = fmb.check(model)
    assert "again: Formula" in report.redundant
    expected = fmb.accelerations(model)
    scale = max(1.0, float(np.max(np.abs(expected.a))))
    for formulation in FORMULATIONS:
        found = fmb.accelerations(model, formulation=formulation)
        np.testing.assert_allclose(found.a, expected.a, rtol=1e-9, atol=1e-9 * scale)
        size = max(1.0, float(np.max(np.abs(expected.lam))))
        np.testing.assert_allclose(found.lam, expected.lam, rtol=1e-9, atol=1e-9 * size)
    turned = fmb.equations(model).in_euler_parameters()
    lengths = null_space(turned.B)  # of three Euler parameters: no velocity, and no inertia
    assert lengths.shape[1] == 3
    np.testing.assert_allclose(turned.M @ lengths, 0.0, atol=1e-12)
    solved = turned.solve()
    np.testing.assert_allclose(turned.B @ solved.a + turned.Bdot_u, expected.a, rtol=1e-8, atol=1e-9 * scale)


@pytest.mark.parametrize("elastic", [False, True], ids=["rigid", "elastic"])
@pytest.mark.parametrize("seed", [50, 51])
def test_force_of_a_constraint_that_is_not_ideal(seed, elastic):
    """Udwadia's third term by hand: C = -x^2 v_z dv_z/du, a from the formula as printed, and its share of the force.

    The bodies are not turned at the start, so that v_z is the third component in W.
    """
    model = random_model(np.random.default_rng(seed), 3, elastic)
    third = model.joint("c2")
    where, x = (
        third.over[2].marker if isinstance(third.over, (list, tuple)) else third.over["v"].marker,
        third.parameters["x"],
    )
    ideal = fmb.equations(replace(model, joints=[replace(j, forces={}) if j is third else j for j in model.joints]))
    along = ideal.partial_velocity(where)[0][2]
    C = -((x.value if hasattr(x, "value") else x) ** 2) * (along @ ideal.u) * along
    given = fmb.equations(model)
    np.testing.assert_allclose(given.Q - ideal.Q, C, atol=1e-9 * np.abs(ideal.Q).max())
    scale = 1.0 / np.sqrt(np.diag(ideal.M))
    M, A, Q = scale[:, None] * ideal.M * scale, ideal.A * scale, scale * (ideal.Q + C)
    inverse = np.linalg.pinv(A, rcond=1e-10)
    project = np.eye(len(M)) - inverse @ A
    a = scale * (np.linalg.pinv(np.vstack([project @ M, A]), rcond=1e-10) @ np.concatenate([project @ Q, ideal.b]))
    found = ideal.solve(C=C)
    size = np.abs(a).max()
    np.testing.assert_allclose(found.a, a, atol=1e-9 * size)
    np.testing.assert_allclose(fmb.accelerations(model).a, a, atol=1e-9 * size)
    np.testing.assert_allclose(found.force - found.ideal, C, atol=1e-9 * np.abs(found.force).max())
    np.testing.assert_allclose(
        ideal.M @ found.a, ideal.Q + C + ideal.A.T @ found.multipliers, atol=1e-8 * np.abs(found.force).max()
    )
    assert np.abs(C).max() > 1e-3
