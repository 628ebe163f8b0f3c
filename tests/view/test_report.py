"""Reports: self-contained pages whose numbers are those of the run."""

import importlib
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from html import escape
from html.parser import HTMLParser

import numpy as np
import pytest

import flexmb as fmb
from flexmb import view
from flexmb.errors import DataFileError, FlexmbError, duration
from flexmb.view import curves, graphics, report
from flexmb.view.quantities import number, scaled, shown_columns, sizes

report_page = importlib.import_module("flexmb.view.report")
"""The module; the function of its name covers it."""
VOID = {"meta", "img", "br", "link"}


class Page(HTMLParser):
    """Reads a page: its tables as lists of rows of text, its links, and whether every tag is closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tables, self.links, self.headings, self._cell = [], [], [], [], None
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.links += [value for name, value in attributes if name in ("src", "href", "xlink:href")]
        if tag not in VOID:
            self.open.append(tag)
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in ("td", "th") or tag == "h2":
            self._cell = ""

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        if tag in ("td", "th"):
            self.tables[-1][-1].append(self._cell.strip())
        if tag == "h2":
            self.headings.append(self._cell)

    def handle_data(self, data):
        if self._cell is not None:
            self._cell += data

    def handle_startendtag(self, tag, attributes):
        self.links += [value for name, value in attributes if name in ("src", "href", "xlink:href")]

    def table(self, first):
        """Return the rows below the titles of the table whose first title is `first`."""
        return next(rows[1:] for rows in self.tables if rows[0][0] == first)


def bar(g=9.81, break_at=None):
    """A bar on a hinge, released from the horizontal; its pin may break when the bar hangs steeply."""
    events = [fmb.Event("break", sensor="tip", column=2, below=break_at, then=fmb.Release("pin"))] if break_at else []
    return fmb.Model(
        name="bar & pin",
        gravity=(0, 0, -g),
        bodies=[
            fmb.Ground(markers={"A": fmb.Pose.axes((0, 0, 0), z=(0, 1, 0), x=(1, 0, 0))}),
            fmb.RigidBody.rod(
                "bar", length=1.0, mass=2.0, markers={"A": fmb.Pose.axes((0, 0, 0), z=(0, 1, 0), x=(1, 0, 0))}
            ),
        ],
        joints=[fmb.Revolute("pin", markers=("ground.A", "bar.A"))],
        sensors=[
            fmb.Position("tip", marker="bar.end"),
            fmb.Reaction("pin force", joint="pin"),
            fmb.JointCoordinate("angle", joint="pin"),
            fmb.Energy("energy"),
        ],
        events=events,
        parameters={"g": g},
    )


@pytest.fixture(scope="module")
def swing():
    return fmb.simulate(bar(), 0.5, samples=51)


@pytest.fixture(scope="module")
def broken():
    return fmb.simulate(bar(break_at=-0.9), 0.6, samples=61)


def read(path):
    text = path.read_text(encoding="utf-8")
    return text, Page(text)


def test_one_run(swing, tmp_path):
    path = report(
        {"swing": swing}, tmp_path / "new" / "report.html", checks={"swing": fmb.check(swing.model)}, pictures=False
    )
    text, page = read(path)
    assert page.headings == ["Curves", "Extremes", "Loads", "Energy", "Mobility", "Model", "Solver"]
    assert all(link.startswith(("#", "data:")) for link in page.links)
    assert "<script" not in text
    assert "bar &amp; pin" in text
    assert "Reached its end without a warning" in text
    rows = {row[0]: row for row in page.table("sensor")}
    z = swing["tip"][:, 2]
    assert float(rows["tip z"][2]) == pytest.approx(z.min(), rel=1e-3)
    assert float(rows["tip z"][3]) == swing.t[z.argmin()]
    assert float(rows["angle"][4]) == pytest.approx(np.degrees(swing["angle"].max()), rel=1e-3)
    assert rows["angle"][1] == "deg"
    assert "tip y" not in rows
    assert "energy" not in rows
    assert page.table("run")[0][0] == "swing"
    assert ["bar", "RigidBody", "2.000", "", ""] in page.table("body")
    mobility = next(rows for rows in page.tables if "mobility" in rows[0])
    assert mobility[1][1:5] == ["6", "5", "1", "1"]


def test_errors_of_reactions_have_a_line_each(swing, tmp_path):
    """In percent, by joint; no text of a mapping."""
    errors = {"Joint 'pin'": 0.0065, "Joint 'strut'": 2.5}
    told = replace(swing, statistics={**swing.statistics, "errors of reactions": errors})
    other = replace(swing, statistics={"steps": 3})
    text, page = read(report({"a": told, "b": other}, tmp_path / "report.html", pictures=False))
    assert page.table("errors of reactions")[-2:] == [["Joint 'pin'", "0.7 %", ""], ["Joint 'strut'", "250.0 %", ""]]
    assert "{" not in text.partition("<h2>Solver")[2]


def test_loads_are_peaks_of_magnitude(swing, tmp_path):
    _, page = read(report(swing, tmp_path / "report.html", pictures=False))
    force = np.linalg.norm(swing["pin force"][:, :3], axis=1)
    row = page.table("joint or force")[0]
    assert row[:2] == ["pin", "Revolute"]
    assert float(row[2]) == pytest.approx(force.max(), rel=1e-3)
    assert float(row[3]) == swing.t[force.argmax()]


def test_balance_of_energy(swing, tmp_path):
    """m g l/2 = 9.81 J become kinetic energy while the bar falls; the balance closes."""
    _, page = read(report(swing, tmp_path / "report.html", pictures=False))
    row = next(rows for rows in page.tables if "balance misses" in rows[0])[1]
    kinetic = -2.0 * 9.81 * 0.5 * swing["tip"][:, 2].min()
    assert float(row[1]) == pytest.approx(kinetic, rel=1e-3)
    assert float(row[-1].split()[0]) < 0.01


def test_an_event_and_a_joint_that_is_gone(broken, tmp_path):
    text, page = read(report({"run": broken}, tmp_path / "report.html", pictures=False))
    assert len(broken.phases) == 2
    assert f"event &#x27;break&#x27; at t = {broken.phases[0].t[-1]:.6g} s" in text
    assert page.table("joint or force")[0][0] == "pin"


def test_several_runs(swing, broken, tmp_path):
    moon = fmb.simulate(bar(g=1.62), 0.5, samples=51)
    text, page = read(report({"earth": swing, "moon": moon, "broken": broken}, tmp_path / "c.html", pictures=False))
    assert page.table("parameter") == [["g", "9.81", "1.62", "9.81"]]
    assert page.headings[0] == "Differences"
    of_tip = [row for row in page.table("sensor") if row[0] == "tip z" or row[0] == ""][:3]
    assert len(of_tip) == 3
    svg = next(part for part in re.findall(r"<svg.*?</svg>", text, re.DOTALL) if "earth" in part)
    assert all(name in svg for name in ("earth", "moon", "broken"))
    assert all(color in svg for color in curves.COLORS[:3])
    assert text.count("Energy, ") == 3


def test_a_run_that_failed_says_so(swing, tmp_path):
    from dataclasses import replace

    bad = replace(
        swing,
        status=fmb.Status.failed("step size below 1e-12 s", "Check the damping"),
        statistics={**swing.statistics, "warnings": ["Body 'bar' deforms by 20 %"]},
    )
    text, _ = read(report({"bad": bad}, tmp_path / "report.html", pictures=False))
    assert "failed: step size below 1e-12 s. Check the damping." in text
    assert "Body &#x27;bar&#x27; deforms by 20 %" in text
    assert "without a warning" not in text


def test_a_solution_without_its_model(swing, tmp_path):
    stored = fmb.Solution.load(swing.save(tmp_path / "s.h5"))
    _, page = read(report(stored, tmp_path / "report.html"))
    assert page.headings == ["Curves", "Extremes", "Solver"]


@pytest.mark.render
def test_pictures_and_modes(solution, tmp_path):
    text, page = read(report(solution, tmp_path / "report.html"))
    assert page.headings[0] == "Pictures"
    assert text.count("data:image/png;base64,") == 3
    assert "Modes of flexible bodies" in page.headings


@pytest.mark.render
@pytest.mark.slow
def test_labels_in_pictures(solution, tmp_path):
    """A text at a marker is in every still; a marker that no run has is named."""
    marker = next(name for name in solution.model.marker_names() if not name.startswith("ground"))
    pages = [
        view.report(solution, tmp_path / "page.html", labels=labels).read_text() for labels in ({}, {"tip": marker})
    ]
    plain, labelled = (re.findall(r'src="data:image/png;base64,([^"]+)"', page) for page in pages)
    assert len(plain) == len(labelled) > 0
    assert all(one != two for one, two in zip(plain, labelled))
    with pytest.raises(FlexmbError, match=r"label 'tip'.*nothing"):
        view.report({"one": solution}, tmp_path / "page.html", labels={"tip": "nothing.tip"})


def test_names_in_a_report_are_refused_before_it_is_drawn(solution, tmp_path, monkeypatch):
    """A direction for a run that is not there, a label at a body that no run draws."""
    monkeypatch.setattr(report_page, "Stage", None)  # nothing is drawn
    monkeypatch.setattr(report_page, "require_graphics", lambda: None)
    runs, path = {"first": solution, "second": solution}, tmp_path / "page.html"
    with pytest.raises(FlexmbError, match=r"camera: a direction for 'frist'.*Did you mean 'first'"):
        view.report(runs, path, camera={"frist": (1, 0, 0)})
    with pytest.raises(FlexmbError, match=r"hide names 'spring'.*Did you mean 'springs'"):
        view.report(runs, path, hide=("spring",))
    with pytest.raises(FlexmbError, match=r"label 'wall': the body 'ground' is not drawn.*Write 'ground\."):
        view.report(runs, path, labels={"wall": "ground"})
    assert not path.exists()


def test_no_pictures_where_nothing_can_be_drawn(swing, tmp_path, monkeypatch):
    monkeypatch.setattr(graphics, "_outcome", lambda: -11)
    text, _ = read(report(swing, tmp_path / "report.html"))
    assert "None: Rendering: a trial picture ended with code -11" in text


def test_messages(swing, tmp_path):
    with pytest.raises(
        FlexmbError, match=r"Report '.*x\.pdf': the ending '\.pdf'\. Expected: \.html\. Name it report\.html"
    ):
        report(swing, tmp_path / "x.pdf")
    with pytest.raises(FlexmbError, match=r"Report: there is no run\. Expected: at least one"):
        report({}, tmp_path / "x.html")
    (tmp_path / "file").write_text("")
    with pytest.raises(DataFileError, match=r"Report '.*': cannot write it .*Choose another place"):
        report(swing, tmp_path / "file" / "x.html", pictures=False)


def test_curves_keep_their_peaks():
    """Thinning keeps the least and the greatest of every group; the element is XML whose text is text."""
    t = np.linspace(0.0, 1.0, 100_001)
    y = np.zeros_like(t)
    y[54_321] = 7.0
    x, thin = curves._thinned(t, y)
    assert len(x) <= curves.POINTS + 2
    assert thin.max() == 7.0
    assert x[thin.argmax()] == t[54_321]
    svg = curves.svg_curves([curves.Line("a", t, y, "#1f5fa8")], y_label="[kN]", events=[0.5])
    root = ElementTree.fromstring(svg)
    assert root.get("width") is None
    assert root.get("viewBox")
    assert {"time [s]", "[kN]", "a"} <= {element.text for element in root.iter() if element.tag.endswith("text")}


def test_units_of_the_page(swing):
    assert scaled("N", 2e3) == (1e-3, "kN")
    assert scaled("N", 500.0) == (1.0, "N")
    assert scaled("Pa", 3e8) == (1e-6, "MPa")
    assert scaled("m", 0.002) == (1e3, "mm")
    assert scaled("m", 2.0) == (1.0, "m")
    assert scaled("rad", 1.0) == (180.0 / np.pi, "deg")
    assert [number(x) for x in (0.0, 1234.56, 0.012346, 1e-5, 2.5e7, np.nan)] == [
        "0",
        "1235",
        "0.01235",
        "1.000e-05",
        "2.500e+07",
        "-",
    ]
    assert number(1e-9, beside=1.0) == "0"
    assert [duration(x) for x in (0.523, 41.6, 200.0, 7500.0, 2e5, 1e9, np.inf)] == [
        *("0.52 s", "42 s", "3 min 20 s", "2 h 5 min", "2.31 days", "31.7 years", "countless years"),
    ]
    assert [column.title for column in shown_columns(swing, "tip")] == ["x", "z"]
    assert sizes([swing], "tip")["m"] == pytest.approx(1.0)


def test_damping_and_warnings_of_reduced_bodies(tmp_path):
    """The page shows the damping of the body in its model, 3 %, and what its reduction warned of."""
    from reduction.solids import block

    data = fmb.reduction.reduce(block(), {"a": "left", "b": "right"}, modes=0, damping=0.01)
    (poor,) = [text for text in data.quality["warnings"] if text.startswith("The reduced frequency")]
    m = data.n_modes
    beam = fmb.FloatingBody("beam", data=data, damping=0.02)
    twin = fmb.FloatingBody("twin", data=data, at=(0, 0, 1), damping=np.diag([5.0] + [0.0] * (m - 1)))
    model = fmb.Model(bodies=[beam, twin])
    text, page = read(report(fmb.simulate(model, 1e-6, samples=2), tmp_path / "report.html", pictures=False))
    tables = [rows[1:] for rows in page.tables if rows[0][1:2] == ["frequency Hz"]]
    assert [row[4] for row in tables[0]] == ["3.00 %"] * m
    ratio = 5.0 / (2.0 * np.sqrt(data.stiffness[0, 0] * data.invariants.nn[0, 0]))
    assert [row[4] for row in tables[1]] == [f"{100 * ratio:.2f} %"] + ["0.00 %"] * (m - 1)
    assert f"Reduction of beam, twin: {escape(poor)}" in text


def test_what_comes_from_a_file_is_escaped(tmp_path):
    """Statistics, titles and names of a solution file are text, never a part of the page; $ begins no formula."""
    hostile = "<script>alert(1)</script><img src=x onerror=alert(2)> $\\frac"
    model = fmb.Model(
        name=hostile,
        bodies=[fmb.Ground(), fmb.PointMass("stone", mass=1.0)],
        sensors=[fmb.Position(hostile, marker="stone.center")],
    )
    solution = fmb.simulate(model, 0.1, samples=3)
    statistics = {hostile: hostile, "seconds": hostile, "share of validity": {hostile: {hostile: hostile}}}
    path = replace(solution, statistics=statistics, status=fmb.Status.failed(hostile, hostile)).save(
        tmp_path / "run.h5"
    )
    loaded = fmb.Solution.load(path, model=model)
    page = view.report({hostile: loaded}, tmp_path / "report.html", pictures=False).read_text()
    assert "<script>alert" not in page
    assert "<img src=x" not in page
    assert "&lt;script&gt;alert(1)" in page
    assert view.plot(loaded, None, tmp_path / "plot.png").is_file()
