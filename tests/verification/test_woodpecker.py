"""The woodpecker toy: a beak that strikes a pole, and a sleeve that jams on it, slips and jams again.

In the coordinates of Glocker's model: the height of the sleeve and the small angles of sleeve and bird. A body on a
slide stands for each of them, and for the height of the bird; light points are the beak and the sleeve, whose motion
along and across the pole is linear in these.

Source: Glocker & Studer 2005 with the data of Siconos: period 0.14604 s, fall 19.48 mm in each, beak hits at 0.08104 s
and 0.22710 s.
"""

import numpy as np
import pytest

import flexmb as fmb

SLEEVE, SLEEVE_TURN, BIRD, BIRD_TURN = 0.0003, 5e-9, 0.0045, 7e-7  # kg, kg m2
SPRING = 0.0056  # N m
POLE, BORE, HALF = 0.0025, 0.0031, 0.0058  # m, radii of pole and sleeve, half the height of the sleeve
LEVER, REACH, BEAK, FAR = 0.010, 0.015, 0.02, 0.0201  # m: sleeve to spring, spring to bird, beak from bird
UNIT, LIGHT, BALL = 0.01, 1e-9, 0.001  # m on a slide for each rad, kg and m of a point
X = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 0, 1))


def toy():
    """Return the toy as it begins: the sleeve jammed, the bird swinging to the pole."""
    sleeve, bird, falling, swinging = -(BORE - POLE) / HALF, -0.2788, -0.3411, -7.4583
    z_beak = LEVER * sleeve + (REACH - FAR) * bird

    def pole(x, normal):
        return fmb.Pose.axes((x, 0, 0), z=(normal, 0, 0), x=(0, 0, 1))

    def slide(name, mass, at, velocity, axes=None):
        return fmb.RigidBody(name, mass=mass, inertia=(1e-9,) * 3, at=at, rotation=axes, velocity=velocity)

    def law(name, equation, over, **lengths):
        measured = {body: fmb.Position(body, marker=f"{body}.center") for body in over}
        return fmb.Constraint(
            name, markers=("", ""), over=measured, equation=equation, parameters={"u": UNIT, **lengths}
        )

    markers = {
        "x": X,
        "z": (0, 0, 0),
        "front": pole(-(LEVER + REACH - FAR - POLE) - BALL, 1),
        "low": pole(-(BORE - POLE) - BALL, 1),
        "high": pole(BORE - POLE + BALL, -1),
    }
    bodies = [
        fmb.Ground(markers=markers),
        slide("Y", SLEEVE, (0, 0, 0), (0, 0, falling)),
        slide("W", BIRD, (0, 0, LEVER * sleeve + REACH * bird), (0, 0, falling + REACH * swinging)),
        slide("A", SLEEVE_TURN / UNIT**2, (UNIT * sleeve, 0, 0), (0, 0, 0), X.rotation),
        slide("B", BIRD_TURN / UNIT**2, (UNIT * bird, 0, 0), (UNIT * swinging, 0, 0), X.rotation),
        fmb.PointMass("K", mass=LIGHT, at=(HALF * sleeve, 0, BORE * sleeve), velocity=(0, 0, falling)),
        fmb.PointMass(
            "S",
            mass=LIGHT,
            at=(-BEAK * bird, 0, z_beak),
            velocity=(-BEAK * swinging, 0, falling + (REACH - FAR) * swinging),
        ),
    ]
    joints = [
        *(fmb.Prismatic(f"slide of {b}", markers=(f"ground.{axis}", f"{b}.center")) for b, axis in zip("YWAB", "zzxx")),
        law("bird", "W[2] = Y[2] + l*A[0]/u + m*B[0]/u", "WYAB", l=LEVER, m=REACH),
        law("sleeve across", "K[0] = h*A[0]/u", "KA", h=HALF),
        law("sleeve in plane", "K[1] = 0*u", "K"),
        law("sleeve along", "K[2] = Y[2] + r*A[0]/u", "KYA", r=BORE),
        law("beak across", "S[0] = -h*B[0]/u", "SB", h=BEAK),
        law("beak in plane", "S[1] = 0*u", "S"),
        law("beak along", "S[2] = Y[2] + l*A[0]/u + m*B[0]/u", "SYAB", l=LEVER, m=REACH - FAR),
    ]
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=bodies,
        joints=joints,
        surfaces=[
            *(fmb.Surface(name, marker=f"ground.{name}", shape=fmb.Plane()) for name in ("front", "low", "high")),
            fmb.Surface("beak", marker="S.center", shape=fmb.Sphere(BALL)),
            fmb.Surface("sleeve", marker="K.center", shape=fmb.Sphere(BALL)),
        ],
        forces=[
            fmb.SurfaceContact("pecks", surfaces=("front", "beak"), law=fmb.Rigid(restitution=0.5, friction=0.3)),
            fmb.SurfaceContact("jams", surfaces=(("low", "high"), "sleeve"), law=fmb.Rigid(friction=0.3)),
            fmb.Bushing("spring", markers=("A.center", "B.center"), stiffness=(0, 0, SPRING / UNIT**2, 0, 0, 0)),
        ],
        sensors=[fmb.Position("y", marker="Y.center"), fmb.ForceOf("peck", force="pecks")],
    )


@pytest.mark.slow
def test_woodpecker_toy():
    """Hits and, over two periods, the mean period and fall; the first order of the step leaves some per mille."""
    step, t_end = 2e-5, 0.385
    count = round(t_end / step)
    solution = fmb.simulate(toy(), t_end, integrator=fmb.MoreauJean(step=step), samples=count + 1)
    peck = solution["peck"][:, 0] > 0.1 * solution["peck"][:, 0].max()
    hit = np.flatnonzero(peck[1:] & ~peck[:-1]) + 1
    t, y = solution.t[hit] - 0.5 * step, solution["y"][hit, 2]
    assert len(hit) == 3
    np.testing.assert_allclose(t[:2], (0.08104, 0.22710), rtol=2e-3)
    assert (t[2] - t[0]) / 2 == pytest.approx(0.14604, rel=1e-3)
    assert (y[0] - y[2]) / 2 == pytest.approx(19.48e-3, rel=5e-3)
