"""GS05: flap frequencies of a rotating tapered cantilever (Hodges & Rutkowski 1981, recomputed by Ritz)."""

import numpy as np
from verification.rotating_beams import angular_frequencies

import flexmb as fmb
from flexmb import fem, reduction


def test_flap_frequencies(reference):
    """Mass 1 - x/2, flap stiffness (1 - x/2)^3; the published values at rest are 3.8238, 18.3173, 47.2648."""
    x = np.linspace(0, 1, 41)
    sections = [
        fem.Section.values(
            area=1 - 0.5 * s, inertia_y=1e-8 * (1 - 0.5 * s) ** 3, inertia_z=1e-4 * (1 - 0.5 * s) ** 3, torsion=1e-4
        )
        for s in x
    ]
    fe = fem.frame(
        np.linspace([0, 0, 0], [1, 0, 0], 41),
        section=sections,
        shear=False,
        rotary_inertia=False,
        material=fmb.Material(young=1e8, poisson=0.0, density=1.0),
    )
    data = reduction.reduce(fe, {"root": "start"}, 10, geometric_stiffness=True, stress=False)
    blade = fmb.FloatingBody("blade", data=data)
    for eta in (0, 2, 6, 12):
        expected = reference("GS05")["reference"][f"taper=0.5,eta={float(eta)}"]
        np.testing.assert_allclose(angular_frequencies(blade, eta)[:3], expected, rtol=5e-4)
