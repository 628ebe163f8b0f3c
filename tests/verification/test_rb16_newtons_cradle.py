"""RB16: Newton's cradle of five equal balls on strings, elastic: one ball in and one out, two in and two out.

Reference: closed form of successive impacts of two. Reached: velocities just after the collision 1e-12 without gaps,
1e-6 with gaps of 1e-6 m, during which gravity acts.
"""

import numpy as np
import pytest
from scipy.special import ellipk

import flexmb as fmb

DIAMETER = 0.1


def cradle(case, speeds, gap):
    p = case["model"]
    n, pitch = p["n"], DIAMETER + gap
    hooks = {f"p{k}": (k * pitch, 0, p["pendulum_L"]) for k in range(n)}
    balls = [fmb.PointMass(f"b{k}", mass=p["m"], at=(k * pitch, 0, 0), velocity=(speeds[k], 0, 0)) for k in range(n)]
    pairs = [(f"b{k}.center", f"b{k + 1}.center") for k in range(n - 1)]
    return fmb.Model(
        gravity=(0, 0, -p["g"]),
        bodies=[fmb.Ground(markers=hooks), *balls],
        joints=[fmb.Rod(f"string {k}", markers=(f"ground.p{k}", f"b{k}.center")) for k in range(n)],
        sensors=[
            *(fmb.Distance(f"gap {k}", markers=pair) for k, pair in enumerate(pairs)),
            *(fmb.Velocity(f"v{k}", marker=f"b{k}.center") for k in range(n)),
            fmb.Momentum("momentum"),
            fmb.Position("p0", marker="b0.center"),
        ],
        events=[
            fmb.Event(
                f"hit {k}", sensor=f"gap {k}", below=DIAMETER, repeats=True, then=fmb.Impact(pair, restitution=p["e"])
            )
            for k, pair in enumerate(pairs)
        ],
    )


@pytest.mark.parametrize(("gap", "tolerance"), [(0.0, 1e-9), (1e-6, 2e-6)], ids=["touching", "gaps"])
@pytest.mark.parametrize(("name", "speeds"), [("one_ball", (1, 0, 0, 0, 0)), ("two_balls", (1, 1, 0, 0, 0))])
def test_velocities_after_the_collision(reference, name, speeds, gap, tolerance):
    case = reference("RB16")
    solution = fmb.simulate(cradle(case, speeds, gap), 1e-3, samples=3)
    first = next(k for k, phase in enumerate(solution.phases) if phase.ended == "finished")
    k = sum(len(phase.t) for phase in solution.phases[:first])
    found = [solution[f"v{n}"][k, 0] for n in range(5)]
    np.testing.assert_allclose(found, case["reference"][name], atol=tolerance)
    np.testing.assert_allclose(solution["momentum"][k, 0], sum(speeds), atol=tolerance)


def test_it_swings_back(reference):
    """After half a period of the last ball (amplitude theta: 2 sqrt(l / g) K(sin(theta / 2)) ) the first one
    goes up again.
    """
    case = reference("RB16")
    p = case["model"]
    half = 2.0 * np.sqrt(p["pendulum_L"] / p["g"]) * ellipk(1.0 / (4.0 * p["g"] * p["pendulum_L"]))
    solution = fmb.simulate(cradle(case, (1, 0, 0, 0, 0), 0.0), case["duration_s"], samples=301)
    back = [phase.t[-1] for phase in solution.phases if phase.ended == "hit 3" and phase.t[-1] > 0.1]
    assert back[0] == pytest.approx(half, abs=1e-4)
    late = solution.t > half + 1e-3
    np.testing.assert_allclose([solution[f"v{n}"][late, 0] for n in (1, 2, 3, 4)], 0.0, atol=1e-6)
    expected = -np.sqrt(1.0 - 2.0 * p["g"] * (solution["p0"][late, 2]))
    np.testing.assert_allclose(-np.linalg.norm(solution["v0"][late], axis=1), expected, atol=1e-4)
