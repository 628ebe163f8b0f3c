"""The slider-crank of FM03 with rods of any softness, the rod as any kind of flexible body."""

import numpy as np
from verification.simeon_crank import CRANK, OMEGA, ROD, SIDE, YOUNG, slider_crank

import flexmb as fmb
from flexmb import fem, reduction

TIMES = np.linspace(0.0, 0.05, 101)
START = {"at": (CRANK, 0, 0), "velocity": (0, CRANK * OMEGA, 0), "angular_velocity": (0, 0, -CRANK * OMEGA / ROD)}
SECTION = fem.Section.rectangle(SIDE, SIDE)


def material(softness):
    """Return steel whose Young's modulus is divided by the softness."""
    return fmb.Material(young=YOUNG / softness, poisson=0.3, density=7870.0)


def floating(parts):
    """Return a function of the softness that gives the rod as so many floating bodies, and joints between them."""

    def rod(softness):
        fe = fem.frame(
            np.linspace([0, 0, 0], [ROD, 0, 0], 25), section=SECTION, shear=False, material=material(softness)
        )
        ends = {"crank": "start", "slider": "end"}
        if parts == 1:
            data = (
                reduction.reduce(
                    fe, ends, 4, stations={"mid": (ROD / 2, 0, 0)}, geometric_stiffness=True, stress=False
                ),
            )
        else:
            cut = fem.split(fe, at=ROD * np.arange(1, parts) / parts)
            data = reduction.split(cut, ends, 3, stations={"mid": (ROD / 2, 0, 0)}, stress=False)
        return fmb.FloatingBody.split("rod", data, **START)

    return rod


def ancf(kind, elements):
    """Return a function of the softness that gives the rod as an AncfCable or AncfBeam."""
    along_z = np.eye(3)
    return lambda softness: (
        kind(
            "rod",
            points=((0, 0, 0), (ROD, 0, 0)),
            elements=elements,
            section=SECTION,
            material=material(softness),
            **START,
            markers={"crank": (0.0, along_z), "slider": 1.0, "mid": 0.5},
        ),
    )


def bow(rod, softness):
    """Return the deflection of mid-rod from its chord at TIMES, m."""
    bodies = rod(softness)
    place = {
        name: next(f"{body.name}.{name}" for body in bodies if name in body.marker_poses())
        for name in ("crank", "mid", "slider")
    }
    model = slider_crank(
        bodies[0],
        others=bodies[1:],
        ends=(place["crank"], place["slider"]),
        joints=fmb.Fixed.at_cuts(bodies) if len(bodies) > 1 else (),
        sensors=[fmb.Position(name, marker=marker) for name, marker in place.items()],
    )
    motion = fmb.simulate(model, TIMES[-1], samples=TIMES, integrator=fmb.GeneralizedAlpha(rtol=1e-5))
    chord, arm = motion["slider"] - motion["crank"], motion["mid"] - motion["crank"]
    chord /= np.linalg.norm(chord, axis=1)[:, None]
    return chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0]
