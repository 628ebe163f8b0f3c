"""Random models with one to eight constraints of all kinds, dependent ones among them: formulations agree.

Reference: the formulations share no solver (sparse factors, null space, pseudo-inverse, recursion); Udwadia and
Phohomsiri's equation in Euler-parameter rates is solved from the matrices themselves.
"""

import numpy as np
import pytest

import flexmb as fmb

FORMULATIONS = (fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Recursive())


def random_model(rng, count: int) -> fmb.Model:
    """Three bodies, two of them on a ball, and constraints between random markers."""
    places = rng.normal(size=(3, 3))
    bodies = [fmb.Ground(markers={"o": tuple(rng.normal(size=3))})]
    ends = {}
    for k, at in enumerate(places):
        end = rng.normal(size=3) * 0.5
        J = rng.uniform(0.2, 0.3, size=3)
        moving = {"velocity": rng.normal(size=3), "angular_velocity": rng.normal(size=3)}
        markers = {"s": (0, 0, 0), "e": tuple(end), "ball": tuple(places[1] - at if k < 2 else (0, 0, 0))}
        bodies.append(fmb.RigidBody(f"b{k}", mass=rng.uniform(0.5, 2), inertia=J, at=at, markers=markers, **moving))
        ends[f"b{k}.e"] = at + end
    joints = [fmb.Spherical("ball", markers=("b0.ball", "b1.ball"))]
    origin = np.array(bodies[0].markers["o"].at)
    for k in range(count):
        one, two = rng.permutation(3)[:2]
        a, b = f"b{one}.e", f"b{two}.e"
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


@pytest.mark.parametrize("count", range(1, 9))
def test_formulations_agree(count):
    model = random_model(np.random.default_rng(40 + count), count)
    report = fmb.check(model)
    assert "again: Formula" in report.redundant
    expected = fmb.accelerations(model)
    scale = max(1.0, float(np.max(np.abs(expected.a))))
    for formulation in FORMULATIONS:
        found = fmb.accelerations(model, formulation=formulation)
        np.testing.assert_allclose(found.a, expected.a, rtol=1e-9, atol=1e-9 * scale)
        size = max(1.0, float(np.max(np.abs(expected.lam))))
        np.testing.assert_allclose(found.lam, expected.lam, rtol=1e-8, atol=1e-8 * size)
    turned = fmb.equations(model).in_euler_parameters()
    assert np.linalg.matrix_rank(turned.M) == 18
    solved = turned.solve()
    np.testing.assert_allclose(turned.B @ solved.a + turned.Bdot_u, expected.a, rtol=1e-8, atol=1e-9 * scale)
