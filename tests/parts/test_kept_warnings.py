"""What is kept says again what was said when it was made: the second user is warned as the first was."""

import warnings

import pytest
from fem.beams import STEEL

import flexmb as fmb
from flexmb import fem, parts, reduction
from flexmb.io.model_file import OpenModelFile
from flexmb.told import Told, listening, repeat, tell

ENDS = {"a": "start", "b": "end"}
BAR = fem.Section.rectangle(0.02, 0.02)

CABLE = """
[parameters]
pull = 1.0

[[body]]
kind = "Ground"
markers = { A = [0, 0, 0] }

[[body]]
kind = "AncfCable"
name = "rope"
points = [[0, 0, 0], [1, 0, 0]]
elements = 2
section = { kind = "Section", area = 1e-4, inertia_y = 1e-9, inertia_z = 1e-9, torsion = 1e-9 }
material = { kind = "Material", young = 210e3, poisson = 0.3, density = 7850.0 }

[[joint]]
kind = "Spherical"
name = "hold"
markers = ["ground.A", "rope.start"]

[[force]]
kind = "PointLoad"
name = "load"
marker = "rope.end"
force = ["= pull", 0, 0]

[[sensor]]
kind = "Position"
name = "tip"
marker = "rope.end"

[simulation]
t_end = 1e-3
samples = 2
"""


@pytest.fixture(autouse=True)
def _folder(monkeypatch, tmp_path):
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "kept"))


def told_by(make):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = make()
    return made, [(entry.category, str(entry.message)) for entry in caught]


def test_a_reduction_read_from_the_cache_warns_as_the_first():
    fe = fem.frame(points=[(0, 0, 0), (0.5, 0, 0), (1, 0, 0)], section=BAR, material=STEEL)

    def make():
        return parts.reduced(fe, ENDS, 1, basis=reduction.Balanced(20))

    (_, first), (_, again) = told_by(make), told_by(make)
    assert len(parts.kept_bodies()) == 1
    assert [kind for kind, _ in first] == [fmb.ValidityWarning] * len(first)
    assert any("they lock the body" in text for _, text in first)
    assert again == first


def test_a_part_from_the_cache_warns_of_its_material_as_the_first():
    weak = fmb.Material(young=210e3, poisson=0.3, density=7850.0)  # MPa were meant

    def make():
        line = parts.Line(points=[(0, 0, 0), (1, 0, 0)], section=BAR, material=weak, elements=2)
        return parts.Part(name="arm", pieces=[line], interfaces=ENDS, modes=1).reduced()

    (_, first), (_, again) = told_by(make), told_by(make)
    assert [kind for kind, _ in first] == [fem.MeshWarning]
    assert "speed of sound" in first[0][1]
    assert again == first
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(fem.MeshWarning):
            make()


def test_parts_of_an_opened_model_file_warn_each_time(tmp_path):
    path = tmp_path / "rope.toml"
    path.write_text(CABLE)
    opened = OpenModelFile(path)
    told = [told_by(lambda pull=pull: opened.model({"pull": pull}))[1] for pull in (1.0, 2.0)]
    assert "speed of sound" in told[0][0][1]
    assert told[1] == told[0]


def test_every_row_of_a_compiled_sweep_has_its_warnings(tmp_path):
    path = tmp_path / "rope.toml"
    path.write_text(CABLE)
    rows = fmb.sweep(path, {"pull": [1.0, 2.0, 3.0]}, engine="compiled", jobs=1).rows
    assert all("speed of sound" in row.warnings for row in rows)


def test_a_run_keeps_what_is_said_of_lost_digits():
    """1e7 m away positions are rounded to 2e-9 m, 2e-8 of a pendulum of 0.1 m: said, and in the run's statistics."""
    far = (1e7, 0.0, 0.0)
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"A": far}),
            fmb.RigidBody(
                "rod", mass=1.0, inertia=(1e-3, 1e-3, 1e-3), at=(1e7 + 0.1, 0, 0), markers={"A": (-0.1, 0, 0)}
            ),
        ],
        joints=[fmb.Revolute("A", markers=("ground.A", "rod.A"))],
    )
    solution, told = told_by(lambda: fmb.simulate(model, 1e-3, samples=2))
    said = [text for _, text in told]
    assert any("positions are rounded" in text for text in said)
    assert set(said) == set(solution.statistics["warnings"])


def test_listeners_hear_whatever_the_filters_show():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with listening() as heard:
            tell("one")
            tell("one", UserWarning)
            with listening() as inner:
                repeat([Told(UserWarning, "two")] * 2)
    assert heard == [Told(fmb.ValidityWarning, "one"), Told(UserWarning, "one"), Told(UserWarning, "two")]
    assert inner == heard[2:]


def test_a_warning_of_elements_names_its_part():
    """A line without a name, 4 km long: the message says whose it is, the first time and from the cache."""
    line = parts.Line(points=[(0, 0, 0), (4e3, 0, 0)], elements=2, section=BAR, material="steel")
    part = parts.Part(name="jib", pieces=[line], interfaces={"root": "start"}, modes=0, compare=0)
    for _ in range(2):
        told = [text for _, text in told_by(part.reduced)[1] if "Frame 'line'" in text]
        assert told
        assert all(text.startswith("Part 'jib': Frame 'line': ") for text in told)
