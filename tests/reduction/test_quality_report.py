"""The quality report: numbers that can be held against closed forms, and the warnings with their remedies."""

import json
from dataclasses import replace

import numpy as np
import pytest
from reduction.beams import planar_beam
from reduction.solids import block
from scipy.linalg import eigh

from flexmb import reduction
from flexmb.errors import ReductionError
from flexmb.model.modal_neutral_data import ModalNeutralData

BOTH = {"a": "left", "b": "right"}


@pytest.fixture(scope="module")
def data():
    return reduction.reduce(
        block(), BOTH, modes=8, loads={"air": "top"}, stations={"m": "mid"}, geometric_stiffness=True
    )


def test_report_is_json_and_survives_the_file(data, tmp_path):
    loaded = ModalNeutralData.load(data.save(tmp_path / "block.h5"))
    assert loaded.quality == json.loads(json.dumps(data.quality))
    assert loaded.report() == data.report() == reduction.report(data)


def test_text_answers_the_questions(data):
    text = data.report()
    parts = [
        "14 flexible coordinates",
        "frame: buckens",
        "1 load shapes (air)",
        "geometric stiffness",
        "stress modes",
    ]
    parts += [
        "mass            7.536 kg (mesh 7.536 kg)",
        "6 removed",
        "a                rigid",
        "static error",
    ]
    parts += [
        "within 1 % up to",
        "8 fixed-interface modes",
        "Effective mass",
        "normal mode 1",
    ]
    parts += ["interface motion", "compliance", "effective mass"]
    for part in parts:
        assert part in text, part


def test_data_without_a_report_still_say_what_they_are(data):
    assert "14 flexible coordinates" in replace(data, quality={}).report()


def test_full_frequencies_are_those_of_the_free_beam(reference):
    data = reduction.reduce(planar_beam(), BOTH, modes=4)
    found = [row["full"] for row in data.quality["frequencies"]]
    np.testing.assert_allclose(found, reference("CB01")["reference"]["full_elastic_Hz"], rtol=1e-8)


def test_effective_mass():
    """The first mode of a clamped-clamped beam holds 69.0 % of the mass.

    Closed form for uniform beams: (int phi dx)^2 / (L int phi^2 dx) = 0.8309^2 = 0.6904 (Blevins).
    """
    data = reduction.reduce(planar_beam(n_el=30), BOTH, modes=58)
    table = data.quality["effective_mass"]
    assert table["directions"] == ["y", "rotation z"]
    np.testing.assert_allclose(table["per_mode"][0][0], 0.6904, atol=5e-3)
    np.testing.assert_allclose(table["sum"][0], 1.0, atol=0.05)  # the consistent mass couples to the end nodes


def test_rows_of_the_mode_table(data):
    rows = data.quality["modes"]
    np.testing.assert_allclose([row["frequency"] for row in rows], data.frequencies)
    for row in rows:
        np.testing.assert_allclose(sum(row["interfaces"].values()) + row["normal"], 1.0)


def test_clamped_frame_is_compared_by_its_free_frequencies():
    fe = block()
    clamped = reduction.reduce(fe, BOTH, modes=8, frame="a")
    free = reduction.reduce(fe, BOTH, modes=8)
    assert len(free.quality["frequencies"]) == 6
    for a, b in zip(clamped.quality["frequencies"], free.quality["frequencies"], strict=True):
        np.testing.assert_allclose(a["reduced"], b["reduced"], rtol=1e-9)


def test_poor_frequencies_are_warned_about():
    data = reduction.reduce(planar_beam(), BOTH, modes=0)
    assert data.quality["warnings"][0].startswith("The reduced frequency 1 (31.88 Hz) is 19.9 % above the full model.")
    assert "modes='up to 26.8 Hz within 1 % of the frequencies'" in data.report()


@pytest.mark.parametrize("length", [1.9, 2.0, 2.05, 2.1])
def test_what_a_warning_of_frequencies_says_to_do_helps(length):
    """Three digits of the frequency that is too high may lie below it, and would leave it out."""
    text = reduction.reduce(planar_beam(length=length), BOTH, modes=0).quality["warnings"][0]
    again = reduction.reduce(planar_beam(length=length), BOTH, modes=text.split("modes='")[1].split("'")[0])
    assert again.quality["frequencies"][0]["error"] <= 0.01
    assert not any("reduced frequency 1 " in words for words in again.quality["warnings"])


def test_shapes_of_loads_are_no_modes():
    loads = {"push": {10: (0.0, 1.0, 0.0)}, "turn": {7: (0.0, 0.0, 0.0, 0.0, 0.0, 1.0)}}
    data = reduction.reduce(planar_beam(), BOTH, 3, loads=loads, residual_vectors="all", error_up_to=100.0)
    assert "3 fixed-interface modes and 2 shapes of loads" in data.report()
    assert data.quality["joined_shapes"] == 2


def test_units_are_looked_at():
    fe = block()
    millimetres = replace(fe, nodes=fe.nodes * 1e-2)  # mass of metres in a box of centimetres
    warnings = reduction.reduce(millimetres, BOTH, modes=8, stress=False).quality["warnings"]
    assert any("kg/m3, more than any metal. Check the units" in text for text in warnings)
    stiff = replace(fe, K=fe.K * 1e6)
    warnings = reduction.reduce(stiff, BOTH, modes=8, stress=False).quality["warnings"]
    assert any("m/s, faster than sound in any solid. Check the units" in text for text in warnings)


def test_a_weak_ground_spring_is_reported():
    fe = planar_beam()
    K = fe.K.tolil()
    K[20, 20] *= 1.0 + 1e-6
    data = reduction.reduce(replace(fe, K=K.tocsr()), BOTH, modes=4)
    assert any("a weak spring to the ground: remove it" in text for text in data.quality["warnings"])


def test_a_station_in_other_units_is_reported():
    data = reduction.reduce(block(), {"a": "left"}, modes=2, stations={"near": (0.1, 0.0, 0.0), "tip": (100.0, 0, 0)})
    (text,) = [text for text in data.quality["warnings"] if "Station" in text]
    assert text.startswith("Station 'tip' is 9")
    assert "Coordinates are metres" in text


def test_good_data_have_no_warning():
    fe = planar_beam()
    data = reduction.reduce(fe, BOTH, modes=10)
    assert data.quality["warnings"] == []
    assert data.report().endswith("No warnings.")
    exact = np.sqrt(eigh(fe.K.toarray(), fe.M.toarray(), eigvals_only=True)[2:8]) / (2 * np.pi)
    np.testing.assert_allclose([row["full"] for row in data.quality["frequencies"]], exact, rtol=1e-8)


def test_frequencies_above_the_band_asked_for_are_not_warned_about():
    """The first frequency of the free beam lies inside the band; those above are as they come."""
    every = reduction.reduce(planar_beam(), BOTH, modes=1).quality["frequencies"]
    asked = f"up to {1.01 * every[0]['full']} Hz within 1 % of the frequencies"
    within = reduction.reduce(planar_beam(), BOTH, modes=asked).quality
    assert within["frequencies"][0]["error"] <= 0.01
    assert max(row["error"] for row in within["frequencies"]) > 0.05
    assert within["warnings"] == []


def test_the_numbers_print_as_paragraphs(data, tmp_path):
    """``print(data.quality)``: what the report says, not a dictionary on one line."""
    text = str(data.quality)
    assert "Free-free frequencies (within 1 %" in text
    assert max(len(line) for line in text.splitlines()) < 160
    assert str(ModalNeutralData.load(data.save(tmp_path / "again.h5")).quality) == text
    assert str(replace(data, quality={}).quality) == "no quality report"
    assert data.quality["mass"]["mass"] == pytest.approx(data.mass)


def test_three_whole_numbers_are_no_place_far_away():
    """(6, 7, 8) may be nodes or metres; a list says nodes, and the origin stays a place."""
    part = block()
    with pytest.raises(ReductionError) as caught:
        reduction.reduce(part, {"a": (6, 7, 8), "b": "right"}, modes=1)
    assert "[6, 7, 8] for three nodes" in str(caught.value)
    assert "(6.0, 7.0, 8.0)" in str(caught.value)
    assert reduction.reduce(part, BOTH, modes=1, stations={"m": (0, 0, 0)}).marker_positions[-1] == pytest.approx(
        [0, 0, 0]
    )
