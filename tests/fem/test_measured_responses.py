"""Frequency responses of a test from universal files, beside the response of a reduced body."""

import numpy as np
import pytest
from fem.beams import straight

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import MeshError
from flexmb.model.material import Material

STEEL = Material(young=210e9, poisson=0.3, density=7850.0)
SIDE, LENGTH = 0.02, 2.0
EI, LINE_MASS = 210e9 * SIDE**4 / 12, 7850.0 * SIDE**2
NONE = "NONE".ljust(80) + "\n"
UNEVEN = (
    "    -1\n    58\n"
    + "tip\n"
    + NONE * 4
    + "    4         0    1         0       NONE         7   3       NONE         2  -3\n"
    "         6         2         0  0.00000e+00  0.00000e+00  0.00000e+00\n"
    "        18    0    0    0 NONE                 NONE\n         8    0    0    0 NONE                 NONE\n"
    "        13    0    0    0 NONE                 NONE\n         0    0    0    0 NONE                 NONE\n"
    "  2.00000e+00   1.00000000000e-05   1.00000000000e-06\n"
    "  1.20000e+01  -2.00000000000e-06  -3.00000000000e-08\n    -1\n"
)
"""Two values of double precision at uneven frequencies, as pyuff 2.5.8 writes them."""


def written(path, frequencies, values, kind, function=4, per=13):
    """Write complex values of single precision at even frequencies; `kind` 8, 11, 12: displacement and its rates."""
    step = frequencies[1] - frequencies[0]
    text = "    -1\n    58\n" + NONE * 5
    text += f"{function:5d}{1:10d}{1:5d}{0:10d} {'bar':10s}{11:10d}{3:4d} {'bar':10s}{11:10d}{3:4d}\n"
    text += f"{5:10d}{len(values):10d}{1:10d}{frequencies[0]:13.5E}{step:13.5E}{0.0:13.5E}\n"
    for code in (18, kind, per, 0):
        text += f"{code:10d}{0:5d}{0:5d}{0:5d} {'NONE':20s} {'NONE':20s}\n"
    numbers = np.stack([values.real, values.imag], axis=1).ravel()
    text += "".join(f"{x:13.5E}" + ("\n" if k % 6 == 5 else "") for k, x in enumerate(numbers))
    path.write_text(text + "\n    -1\n")
    return path


def tip_receptance(frequency):
    """Bishop & Johnson, The Mechanics of Vibration (1960), table 7.1: tip of a clamped beam, force at the tip."""
    b = np.sqrt(2 * np.pi * frequency) * (LINE_MASS / EI) ** 0.25
    x = b * LENGTH
    return (np.sin(x) * np.cosh(x) - np.cos(x) * np.sinh(x)) / (EI * b**3 * (1 + np.cos(x) * np.cosh(x)))


@pytest.mark.parametrize(
    ("kind", "rate", "name"), [(8, 0, "displacement"), (11, 1, "velocity"), (12, 2, "acceleration")]
)
def test_a_response_beside_a_reduced_body(tmp_path, kind, rate, name):
    """The closed form of a cantilever stands for the measurement; the reduced body answers alike."""
    frequencies = np.arange(12.0, 21.0, 2.0)  # between the first and the second resonance, 4.2 and 26 Hz
    rates = tip_receptance(frequencies) * (2j * np.pi * frequencies) ** rate
    path = written(tmp_path / "test.unv", frequencies, rates, kind)
    (measured,) = fem.read_measured_responses(path)
    assert (measured.point, measured.direction, measured.force_point, measured.measured) == (11, 3, 11, name)
    section = fem.Section.rectangle(SIDE, SIDE)
    fe = fem.frame(points=straight(20, LENGTH), section=section, material=STEEL, shear=False, rotary_inertia=False)
    data = reduction.reduce(fe, {"root": "start", "tip": "end"}, 8, stress=False)
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("beam", data=data)],
        joints=[fmb.Fixed("clamp", markers=("ground.origin", "beam.root"))],
    )
    own = fmb.linearize(model).frequency_response(measured.frequencies, "beam.tip", "beam.tip")
    across = abs(measured.direction) - 1
    np.testing.assert_allclose(own[:, across, across].real, measured.receptance.real, rtol=2e-3)
    np.testing.assert_allclose(measured.receptance.imag, 0.0, atol=1e-5 * np.abs(measured.receptance).max())


def test_uneven_frequencies_of_double_precision(tmp_path):
    path = tmp_path / "test.uff"
    path.write_text(UNEVEN)
    (found,) = fem.read_measured_responses(path)
    np.testing.assert_allclose(found.frequencies, [2.0, 12.0])
    np.testing.assert_allclose(found.receptance, [1e-5 + 1e-6j, -2e-6 - 3e-8j])
    assert (found.point, found.direction, found.force_point, found.force_direction) == (7, 3, 2, -3)


def test_the_value_at_rest_of_an_acceleration_is_unknown(tmp_path):
    path = written(tmp_path / "test.unv", np.array([0.0, 1.0, 2.0]), np.ones(3) + 0j, 12)
    (found,) = fem.read_measured_responses(path)
    assert np.isnan(found.receptance[0])
    np.testing.assert_allclose(found.receptance[1:], [-1 / (2 * np.pi) ** 2, -1 / (4 * np.pi) ** 2], rtol=1e-5)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("    4         0    1", "    6         0    1"), "no frequency responses; its datasets are 58"),
        (("        13    0", "        12    0"), "no frequency responses"),
        (("         7   3", "         7   9"), "directions 9 and -3.*1 to 6"),
        (("         6         2         0", "         6         5         0"), "6 numbers in dataset 58.*15"),
        (("         6         2         0", "         3         2         0"), "type 2, 4, 5 or 6"),
        (("  1.20000e+01", "  1.00000e+00"), "rising frequencies"),
        (("-2.00000000000e-06", "-2.000000x0000e-06"), "the line '1.20000e"),
        (("    58\ntip\n" + NONE * 4, "    58\n" + NONE * 2), "in dataset 58|lines"),
    ],
)
def test_other_functions_and_damaged_datasets(tmp_path, change, words):
    assert change[0] in UNEVEN
    path = tmp_path / "test.unv"
    path.write_text(UNEVEN.replace(*change, 1))
    with pytest.raises(MeshError, match=f"(?s){words}"):
        fem.read_measured_responses(path)


def test_binary_datasets_are_refused(tmp_path):
    """As pyuff 2.5.8 writes them: the end stands directly behind the bytes."""
    path = tmp_path / "test.unv"
    head = f"    -1\n    58b{1:6d}{2:6d}{11:12d}{48:12d}\n".encode()
    path.write_bytes(head + b"NONE\n" * 11 + bytes(range(100, 148)) + b"    -1\n")
    with pytest.raises(MeshError, match=r"binary dataset 58b.*ASCII"):
        fem.read_measured_responses(path)
    with pytest.raises(MeshError, match=r"no such file"):
        fem.read_measured_responses(tmp_path / "gone.unv")
