"""Model files that ask for too much, or name what is no file: each ends with a message that says what and where."""

import os
import re

import numpy as np
import pytest

import flexmb as fmb
from flexmb import io
from flexmb.errors import ModelError
from flexmb.io import model_file

STONE = '[[body]]\nkind = "PointMass"\nname = "stone"\nmass = 1.0\n'
DOUBLED = "[signals]\ns0 = { ramp = { rate = 1 } }\n"
DOUBLED += "\n".join(f's{k + 1} = {{ sum = ["= s{k}", "= s{k}"] }}' for k in range(25))
NESTED = "[signals]\ns0 = { ramp = { rate = 1 } }\n"
NESTED += "\n".join(f's{k + 1} = {{ sum = ["= s{k}", 1.0] }}' for k in range(900))
CASES = {
    "a list of signals": ("signals = []", r"x\.toml, \[signals\]: it is no table"),
    "digits": ("gravity = [" + "9" * 400 + ", 0, 0]", "an integer of 333 hexadecimal digits in 'gravity'"),
    "very many digits": ("gravity = [" + "9" * 5000 + ", 0, 0]", "Model file '.*': "),
    "zero byte in a base": (
        r'base = "a\u0000.toml"',
        r"x\.toml, base: 'a\\x00\.toml', 7 characters\. .*name of a file",
    ),
    "long name of a base": (f'base = "{"n" * 5000}"', "'nnn.*, 5000 characters. Expected: the name of a file"),
    "long name of an assembly": (f'[[assembly]]\nfile = "{"n" * 300}"\nprefix = "a"', "300 characters"),
    "long name of a body": (f'{STONE}[[body]]\nkind = "FloatingBody"\nname = "b"\ndata = "{"n" * 300}"', "300 charact"),
    "brackets": ("a = " + "[" * 5000 + "]" * 5000, "brackets inside each other without end"),
    "lists": ("gravity = " + "[" * 70 + "]" * 70, "values nested more than 60 deep in 'gravity'"),
    "dots": ("[a" + ".a" * 5000 + "]", "values nested more than 60 deep in 'a'"),
    "a device": ('parameters_from = "/dev/zero"', r"Model file '/dev/zero': it cannot be opened \(a device or pipe\)"),
    "a pipe": ('parameters_from = "pipe"', r"pipe': it cannot be opened \(a device or pipe\)"),
    "a folder": ('parameters_from = "."', r"it cannot be opened \(a folder\)"),
    "signals that double": (DOUBLED, r"\d+ operations, signals \d+ deep. Expected: at most 20000 operations"),
    "signals in signals": (NESTED, "signals 61 deep. Expected: at most 20000 operations, and signals 60 deep"),
    "lists that double": (
        "[parameters]\nl0 = [1, 2]\n" + "\n".join(f'l{k + 1} = ["= l{k}", "= l{k}"]' for k in range(40)),
        r"\[parameters\], l16: more than 100000 values",
    ),
    "a chain of parameters": (
        "[parameters]\n" + "\n".join(f'p{k} = "= p{k + 1} + 1"' for k in range(3000)) + "\np3000 = 1",
        "more than 100 parameters that need each other",
    ),
    "column": (
        f'{STONE}[[sensor]]\nkind = "Position"\nname = "s"\nmarker = "stone.center"\n'
        '[[event]]\nkind = "Event"\nname = "e"\nsensor = "s"\nabove = 1\ncolumn = 1.5\nthen = [{ kind = "Stop" }]',
        r"Event 'e': column = 1\.5 of sensor 's'\. Expected: 0 to 2, a whole number",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_refused(case, tmp_path):
    text, match = CASES[case]
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "x.toml").write_text(text)
    with pytest.raises(ModelError, match=match):
        io.load_model(tmp_path / "x.toml")


def test_bases_on_bases(tmp_path):
    for k in range(300):
        (tmp_path / f"b{k}.toml").write_text(f'base = "b{k + 1}.toml"\n' if k < 299 else "")
    with pytest.raises(ModelError, match=r"b100\.toml, base: more than 100 files that build on each other"):
        io.load_model(tmp_path / "b0.toml")


def test_assemblies_in_assemblies(tmp_path):
    for k in range(60):
        inner = f'[[assembly]]\nfile = "a{k + 1}.toml"\nprefix = "a"\n' if k < 59 else ""
        (tmp_path / f"a{k}.toml").write_text(STONE + inner)
    with pytest.raises(ModelError, match="more than 20 assemblies inside each other"):
        io.load_model(tmp_path / "a0.toml")


def test_assemblies_that_double(tmp_path, monkeypatch):
    """Sixteen files would make 65 000 bodies."""
    monkeypatch.setattr(model_file, "ASSEMBLIES", 100)
    (tmp_path / "d0.toml").write_text(STONE)
    for k in range(16):
        both = "".join(f'[[assembly]]\nfile = "d{k}.toml"\nprefix = "{p}"\n' for p in "ab")
        (tmp_path / f"d{k + 1}.toml").write_text(both)
    with pytest.raises(ModelError, match="more than 100 assemblies"):
        io.load_model(tmp_path / "d16.toml")
    assert len(io.load_model(tmp_path / "d4.toml").bodies) == 16


@pytest.mark.parametrize("samples", ["2000000000", "1e300"])
def test_samples(samples, tmp_path):
    (tmp_path / "x.toml").write_text(f"{STONE}[simulation]\nt_end = 1.0\nsamples = {samples}\n")
    found = re.escape(repr(float(samples) if "e" in samples else int(samples)))
    with pytest.raises(
        ModelError, match=f"samples = {found}. Expected: a whole number of at least 2 and at most 50000000"
    ):
        io.load_simulation(tmp_path / "x.toml")
    model = io.load_model(tmp_path / "x.toml")
    with pytest.raises(ModelError, match=r"a whole number of at least 2 .* at most 50000000"):
        fmb.simulate(model, t_end=1.0, samples=float(samples))


def test_numbers_beyond_all_floats():
    huge = 10**400
    with pytest.raises(ModelError, match="mass = 1000"):
        fmb.PointMass("p", mass=huge)
    with pytest.raises(ModelError, match="gravity = "):
        fmb.Model(gravity=(0, 0, huge))
    with pytest.raises(ModelError, match="y has no list of numbers"):
        fmb.table([0, 1], [0, huge])
    with pytest.raises(ModelError, match="inertia"):
        fmb.RigidBody("b", mass=1, inertia=(1, 1, huge))


def test_an_inertia_beyond_all_floats():
    bar = fmb.RigidBody("bar", mass=1e308, inertia=(1, 1, 1), center_of_mass=(1e30, 0, 0), markers={"A": (0, 0, 0)})
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"A": (0, 0, 0)}), bar], joints=[fmb.Revolute("h", markers=("ground.A", "bar.A"))]
    )
    with pytest.raises(fmb.FlexmbError, match="beyond the range of numbers"):
        fmb.check(model)


def test_lists_of_parameters_are_computed_once(tmp_path):
    """A list of ten thousand numbers is read once and evaluated element by element."""
    numbers = ", ".join(str(k) for k in range(10_000))
    (tmp_path / "x.toml").write_text(f'[parameters]\nx = [{numbers}]\ny = "= 2*x + 1"\n')
    found = io.load_model(tmp_path / "x.toml").parameters["y"]
    np.testing.assert_array_equal(found, 2.0 * np.arange(10_000) + 1.0)
