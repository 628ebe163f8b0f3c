"""The report as a web page and as JSON: every coordinate, every warning, nothing from elsewhere."""

import json
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from reduction.beams import planar_beam
from reduction.solids import block

from flexmb import reduction
from flexmb.errors import DataFileError
from flexmb.io import report_numbers, write_report
from flexmb.model.mode_table import mode_table


@pytest.fixture(scope="module")
def data():
    return reduction.reduce(block(), {"a": "left", "b": "right"}, modes=8, stations={"m": "mid"}, damping=0.02)


class Page(HTMLParser):
    """Rows of tables, the text, and whatever would be loaded from elsewhere; refuses tags that do not match."""

    def __init__(self, text):
        super().__init__()
        self.rows, self.text, self.links, self.open = [], [], [], []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attributes):
        self.links += [value for key, value in attributes if key in ("src", "href") and value]
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th"):
            self.rows[-1].append("")
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)
        if "td" in self.open or "th" in self.open:
            self.rows[-1][-1] += data


def test_page_has_every_coordinate(data, tmp_path):
    page, numbers = write_report(data, tmp_path / "out" / "block.h5")
    assert (page.name, numbers.name) == ("block.html", "block.json")
    found = Page(page.read_text(encoding="utf-8"))
    assert found.links == []
    first = next(k for k, row in enumerate(found.rows) if row[:2] == ["no.", "frequency Hz"])
    titles, rows = found.rows[first], found.rows[first + 1 : first + 1 + data.n_modes]
    assert titles[2:7] == ["kind", "interface", "damping", "compliance", "effective mass"]
    assert titles[7:] == ["a", "b", "normal modes"]
    assert [row[0] for row in rows] == [str(k + 1) for k in range(data.n_modes)]
    np.testing.assert_allclose([float(row[1]) for row in rows], data.frequencies, rtol=1e-5)
    assert {row[4] for row in rows} == {"2.00 %"}
    assert "None." in found.text


def test_page_says_what_the_text_says(tmp_path):
    """Basis, shapes of loads, bound of the response and what is missing under loads that move."""
    loads = {"rail": reduction.Track("edge"), "push": {0: (0.0, 1.0, 0.0)}}
    given = {"loads": loads, "residual_vectors": ["push"], "error_up_to": 2000.0, "stress": False}
    for basis, words in (("CraigBampton", "2 fixed-interface modes and 3 shapes of loads"), ("Rubin", "Basis Rubin()")):
        body = reduction.reduce(block(), {"a": "right"}, 2, basis=basis, **given)
        path, _ = write_report(body, tmp_path / f"{basis}.html", picture=None)
        text = " ".join(Page(path.read_text(encoding="utf-8")).text)
        assert words in text
        for line in body.report().splitlines():
            if line.startswith(("Response to loads", "  error ", "  response ", "Loads that move", "  rail ")):
                assert " ".join(line.split()) in text
        assert "  rail " in body.report()
    joined = body.quality["tracks"]["rail"]["shapes"]
    assert joined == 2


def test_numbers(data, tmp_path):
    _, path = write_report(data, tmp_path / "block")
    numbers = json.loads(path.read_text())
    assert numbers == json.loads(json.dumps(report_numbers(data)))
    assert numbers["schema"] == "flexmb.quality_report"
    assert numbers["interfaces"] == ["a", "b"]
    assert numbers["stations"] == ["m"]
    assert numbers["quality"]["warnings"] == []
    assert len(numbers["coordinates"]) == data.n_modes


def test_shares_of_a_coordinate_sum_to_one(data):
    table = mode_table(data)
    for row in table:
        np.testing.assert_allclose(sum(row["participation"].values()), 1.0)
    np.testing.assert_allclose(sum(row["compliance"] for row in table), 1.0)


def test_compliance_of_a_clamped_beam():
    """Tip of a cantilever under an end force: the exact share of mode 1 is 12 / 1.8751^4 = 0.9707 (phi(L)^2 = 4 / m).

    Closed form: phi_1(L)^2 / w_1^2 over L^3 / (3 E I) with w_1^2 = 1.8751^4 E I / (m L^3) (Blevins). The table takes
    the mean with the rotation, 4 sigma^2 lambda^2 / lambda^4 with sigma = 0.7341, of the flexibility L / (E I).
    """
    fe = planar_beam(n_el=40)
    data = reduction.reduce(fe, {"a": "left", "b": "right"}, modes=20, frame="a", compare=0, stress=False)
    translation, rotation = 12 / 1.8751041**4, 4 * 0.7340955**2 / 1.8751041**2
    np.testing.assert_allclose(mode_table(data)[0]["compliance"], (translation + rotation) / 2, rtol=1e-4)


def test_effective_mass_belongs_to_the_normal_mode(data):
    table = data.quality["effective_mass"]
    named = [row for row in mode_table(data) if row["kind"].startswith("normal mode")]
    assert named
    for row in named:
        k = int(row["kind"].split()[-1]) - 1
        assert list(row["effective_mass"].values()) == table["per_mode"][k]
        assert list(row["effective_mass"]) == table["directions"]
    others = [row for row in mode_table(data) if row["kind"] == "interface motion"]
    assert all(row["effective_mass"] == {} for row in others)


def test_selected_modes_keep_their_rows(data):
    rows, chosen = mode_table(data), mode_table(data.selected([3, 7]))
    assert [row["kind"] for row in chosen] == [rows[3]["kind"], rows[7]["kind"]]
    assert [row["frequency"] for row in chosen] == [rows[3]["frequency"], rows[7]["frequency"]]


def test_warnings_and_names_are_text_not_tags(tmp_path):
    poor = reduction.reduce(planar_beam(), {"<a>": "left", "b": "right"}, modes=0)
    page, _ = write_report(replace(poor, name="<b>&"), tmp_path / "x.html")
    text = "".join(Page(page.read_text(encoding="utf-8")).text)
    assert "19.9 % above the full model" in text
    assert "<b>&" in text
    assert "<a>" in text


def test_data_without_a_report_and_with_a_picture(data, tmp_path):
    picture = tmp_path / "dot.png"
    picture.write_bytes(b"\x89PNG")
    page, _ = write_report(replace(data, quality={}), tmp_path / "x.html", picture=picture)
    found = Page(page.read_text(encoding="utf-8"))
    assert found.links == ["data:image/png;base64,iVBORw=="]
    assert len(found.rows) == 1 + data.n_modes


def test_a_folder_that_cannot_be_written(data, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(DataFileError, match=r"Report '.*x\.html': cannot write it.*a writable folder"):
        write_report(data, tmp_path / "file" / "x.html")
