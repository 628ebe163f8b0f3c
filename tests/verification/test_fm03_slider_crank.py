"""FM03: flexible slider-crank (Simeon's data) from beam elements; reference: geometrically exact rod, spectral.

The rod is free at both pins, so it bends as a beam on hinges while its frame follows the mechanism.
"""

import numpy as np
import pytest
from verification.simeon_crank import CRANK, OMEGA, ROD, SIDE, YOUNG, slider_crank

import flexmb as fmb
from flexmb import fem, reduction


def deflection(times, modes):
    """Return the transverse deflection of mid-rod from the chord, m, and the slider's position, m, at times."""
    section = fem.Section.rectangle(SIDE, SIDE)
    fe = fem.frame(
        np.linspace([0, 0, 0], [ROD, 0, 0], 21),
        section=section,
        shear=False,
        material=fmb.Material(young=YOUNG, poisson=0.3, density=7870.0),
    )
    data = reduction.reduce(
        fe,
        {"crank": "start", "slider": "end"},
        modes,
        stations={"mid": (ROD / 2, 0, 0)},
        geometric_stiffness=True,
        stress=False,
    )
    speed = CRANK * OMEGA
    rod = fmb.FloatingBody(
        "rod", data=data, at=(CRANK, 0, 0), velocity=(0, speed, 0), angular_velocity=(0, 0, -speed / ROD)
    )
    markers = {"slider": "slider.center", "a": "rod.crank", "mid": "rod.mid", "b": "rod.slider"}
    model = slider_crank(rod, sensors=[fmb.Position(name, marker=marker) for name, marker in markers.items()])
    motion = fmb.simulate(model, times[-1], samples=[0.0, *times], integrator=fmb.GeneralizedAlpha(rtol=1e-6))
    chord, arm = motion["b"] - motion["a"], motion["mid"] - motion["a"]
    chord /= np.linalg.norm(chord, axis=1)[:, None]
    return (chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0])[1:], motion["slider"][1:, 0]


def test_deflection_of_the_rod(reference):
    case = reference("FM03")["reference"]
    bow, slider = deflection([float(t) for t in case], 4)
    expected = np.array([row["mid_transverse"] for row in case.values()])
    np.testing.assert_allclose(bow, expected, rtol=0, atol=0.02 * np.abs(expected).max())
    # axial vibration of the undamped rod, 1e-5 m, is in both but not in phase
    np.testing.assert_allclose(slider, [row["x_slider"] for row in case.values()], rtol=0, atol=5e-5)


@pytest.mark.slow
def test_error_against_number_of_modes(reference):
    case = reference("FM03")["reference"]
    expected = np.array([row["mid_transverse"] for row in case.values()])
    errors = [np.abs(deflection([float(t) for t in case], modes)[0] - expected).max() for modes in (0, 2, 4, 8)]
    largest = np.abs(expected).max()
    assert errors[0] > 0.2 * largest
    assert max(errors[2:]) < 0.02 * largest
