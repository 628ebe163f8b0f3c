"""Soft springs beside stiff ones: frequencies are right, or told with the place of the stiff one.

Reference: two equal masses, ground - k - m - K - m: w^2 = (k + 2 K -+ sqrt(k^2 + 4 K^2)) / (2 m), for K >> k the soft
one k / (2 m).
"""

import re
import warnings

import numpy as np
import pytest

import flexmb as fmb


def found(stiff: float, soft: float = 1.0):
    """Return the linearised pair, and what it tells."""
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("a", mass=1.0), fmb.PointMass("b", mass=1.0)],
        forces=[
            fmb.Bushing("soft", markers=("ground.origin", "a.center"), stiffness=(soft, 5.0, 5.0, 0, 0, 0)),
            fmb.Bushing("stiff", markers=("a.center", "b.center"), stiffness=(stiff, 5.0, 5.0, 0, 0, 0)),
        ],
    )
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        return fmb.linearize(model), [str(one.message) for one in told]


@pytest.mark.parametrize("stiff", [1e3, 1e8, 1e11])
def test_digits_that_are_left_are_not_told(stiff):
    linear, told = found(stiff)
    assert not told
    square = (1.0 + 2.0 * stiff) / 2.0
    square = stiff / (square + np.sqrt(0.25 + stiff**2))
    assert np.min(linear.frequencies) * 2.0 * np.pi == pytest.approx(np.sqrt(square), rel=1e-4)


@pytest.mark.parametrize("stiff", [4e13, 1e14, 1e15])
def test_digits_that_are_lost_are_told(stiff):
    """Beyond 1e16 the matrix has no digit of the soft spring any more, and nothing can be said of it."""
    (sentence,) = found(stiff)[1]
    assert "linearize" in sentence
    assert "Body 'a', translation along x" in sentence or "Body 'b', translation along x" in sentence
    assert "use a joint" in sentence
    times = float(re.search(r"the stiffness is (\S+) times", sentence)[1])
    if "comes out as zero" in sentence:
        assert "expected: less than once, as of a motion that nothing holds" in sentence
    else:
        assert times < 100.0
        assert "expected: more than 100 times" in sentence


@pytest.mark.parametrize("stiff", [1e6, 1e14])
def test_what_is_free_is_no_doubt(stiff):
    """Without the soft spring the pair has a zero, which is one."""
    linear, told = found(stiff, soft=0.0)
    assert not told
    assert np.min(linear.frequencies) == 0.0


def test_a_rod_on_a_free_cart_is_no_doubt():
    """Upright, its gravity acts along the rail by cos(pi/2) = 6e-17 in numbers: the cart is free, and the rod falls
    with w^2 = m g l/2 (M + m) / ((M + m) m l^2/3 - (m l/2)^2).
    """
    M, m, length, g = 1.0, 0.3, 0.8, 9.81
    along = fmb.Pose.axes(z=(1, 0, 0))
    model = fmb.Model(
        gravity=(0, -g, 0),
        bodies=[
            fmb.Ground(markers={"r": along}),
            fmb.RigidBody("cart", mass=M, inertia=(1e-3,) * 3, markers={"r": along, "pin": (0, 0, 0)}),
            fmb.RigidBody.rod("rod", length=length, mass=m, rotation=(0, 0, np.pi / 2)),
        ],
        joints=[
            fmb.Prismatic("rail", markers=("ground.r", "cart.r")),
            fmb.Revolute("hinge", markers=("cart.pin", "rod.start")),
        ],
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        poles = fmb.linearize(model).eigenvalues
    w = np.sqrt(m * g * length / 2 * (M + m) / ((M + m) * m * length**2 / 3 - (m * length / 2) ** 2))
    assert np.sort(poles.real) == pytest.approx([-w, 0.0, w], rel=1e-8)


@pytest.mark.parametrize(("joint", "freedoms"), [(fmb.Prismatic, 1), (fmb.Planar, 3)])
def test_what_slides_in_any_direction_has_zeros_only(rng, joint, freedoms):
    """Shape and stiffness have rounding where they should have zeros, load and acceleration cancel but for rounding."""
    for _ in range(40):
        axis, across = rng.normal(size=(2, 3))
        guide = fmb.Pose.axes(z=axis, x=across)
        turned = fmb.Pose(rotation=rng.normal(size=3))
        own = fmb.Pose(at=rng.normal(size=3), rotation=turned.matrix.T @ guide.matrix)
        body = fmb.RigidBody(
            "body",
            mass=2.0,
            inertia=(0.02, 0.03, 0.04),
            at=-turned.matrix @ own.at,
            rotation=turned.matrix,
            markers={"guide": own},
        )
        model = fmb.Model(
            bodies=[fmb.Ground(markers={"guide": guide}), body],
            joints=[joint("slide", markers=("ground.guide", "body.guide"))],
            forces=[fmb.PointLoad("push", marker="body.center", force=rng.normal(size=3))],
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", fmb.ValidityWarning)  # it accelerates
            linear = fmb.linearize(model)
        assert linear.eigenvalues.tolist() == freedoms * [0.0]
        assert linear.stable
