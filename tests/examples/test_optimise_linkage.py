"""The optimum of the example against a search on the closed form of the linkage.

The force along the rail is that of the data set's linkage, strut force times the cosine of its angle to the rail; any
other linkage needs R / cos a in its strut and R ds/dphi at its drive (virtual work).
"""

import runpy
from pathlib import Path

import numpy as np
import pytest

import flexmb as fmb

EXAMPLE = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "optimise_linkage.py"))
ALONG, ACROSS, A, E = (EXAMPLE[name] for name in ("ALONG", "ACROSS", "A", "E"))
TRAVEL, STATION = EXAMPLE["TRAVEL"], EXAMPLE["STATION"]


def closed_form(l, h, s, rail):
    """Return peak strut force and drive torque for forces along the rail at strokes s."""
    linkages = [EXAMPLE["linkage"](l, h, stroke) for stroke in s]
    angle = np.array([phi for _, phi in linkages])
    D = A + h * ACROSS + l * (np.outer(np.sin(angle), ALONG) - np.outer(np.cos(angle), ACROSS))
    strut = E + np.outer(s, ALONG) - D
    assert np.linalg.norm(strut, axis=1) == pytest.approx(
        linkages[0][0], abs=1e-6
    )  # the loop closes; ALONG has six digits
    cosine = strut @ ALONG / linkages[0][0]
    return np.abs(rail / cosine).max(), np.abs(rail / np.gradient(angle, s)).max()


@pytest.mark.slow
def test_no_linkage_of_the_closed_form_is_better():
    model = fmb.load_model(STATION / "flap_station.toml", {"lever_modes": 0, "lever_is_rigid": True, "duration": 32.54})
    solution = fmb.kinematics(model, 32.54, samples=201)
    s, phi = solution["carriage stroke"], solution["lever angle"]
    D = A + 0.60 * (np.outer(np.sin(phi), ALONG) - np.outer(np.cos(phi), ACROSS))
    rail = 1e-3 * solution["strut force"][:, 0] * ((E + np.outer(s, ALONG) - D) @ ALONG) / 1.30
    moving = np.concatenate([[True], np.diff(s) > 1e-6])
    s, rail = s[moving], rail[moving]
    force, torque = closed_form(0.60, 0.0, s, rail)
    assert [force, torque] == pytest.approx(EXAMPLE["peaks"]((0.60, 0.0)), rel=5e-3)
    found = [
        force
        for l in np.linspace(0.62, 0.80, 37)
        for h in np.linspace(-0.15, 0.15, 13)
        for force, torque in [closed_form(l, h, s, rail)]
        if torque <= 25.0
    ]
    least = EXAMPLE["main"]()
    assert least == pytest.approx(47.72, abs=0.03)
    assert least == pytest.approx(min(found), rel=2e-3)
