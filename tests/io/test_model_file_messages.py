"""What is said about wrong model files: the file, the table and the field, what was found, expected, and what to do."""

import pytest

from flexmb import io
from flexmb.errors import DataFileError, ModelError

GOOD = """
[parameters]
mass = 2.0

[[body]]
kind = "Ground"
markers = { A = [0, 0, 0] }

[[body]]
kind = "RigidBody"
name = "crank"
mass = "= mass"
inertia = [1, 1, 1]

[[joint]]
kind = "Revolute"
name = "A"
markers = ["ground.A", "crank.center"]

[simulation]
t_end = 1.0
"""

CASES = [
    # syntax and tables
    ("t_end = 1.0", "t_end = ", "Model file '", "line 21", "`t_end =`", "TOML 1.0", "in quotes"),
    (
        "[[joint]]",
        "[[joints]]",
        "crank.toml: there is no table 'joints'",
        "One of: name",
        "Did you mean 'joint'?",
    ),
    ("[[joint]]", "[[jont]]", "there is no table 'jont'", "Did you mean 'joint'?"),
    ("[[joint]]", "[[zzz]]", "there is no table 'zzz'", "Values of your own go into [parameters]"),
    ("[[joint]]", "[joint]", "[joint] is a single table", "[[joint]], one for each", "with two brackets"),
    # kinds and fields
    (
        'kind = "Revolute"',
        'kind = "Revolut"',
        "crank.toml, [[joint]] 'A': kind = 'Revolut' is unknown",
        "Cylindrical",
        "Did you mean 'Revolute'?",
    ),
    ('kind = "Revolute"', 'kind = "Qqq"', "kind = 'Qqq' is unknown", "Correct the kind"),
    ('kind = "Revolute"', "", "[[joint]] 'A': the field 'kind' is missing", "One of: ", 'Add kind = "..."'),
    (
        'kind = "RigidBody"',
        'kind = "RigidBody.spere"',
        "RigidBody has no constructor 'spere'",
        "sphere",
        "Did you mean 'sphere'?",
    ),
    (
        'kind = "Revolute"',
        'kind = "Revolute.rod"',
        "Revolute has no constructor 'rod'",
        "One of: none",
        'Write kind = "Revolute"',
    ),
    (
        "inertia =",
        "inertai =",
        "[[body]] 'crank': there is no field 'inertai'",
        "mass, inertia, center_of_mass",
        "Did you mean 'inertia'?",
    ),
    (
        "inertia =",
        "colour =",
        "there is no field 'colour'",
        "RigidBody has:",
        "Correct the field's name, or remove it",
    ),
    (
        "inertia = [1, 1, 1]",
        "",
        "[[body]] 'crank': the field 'inertia' is missing",
        "RigidBody has:",
        "Give inertia a value",
    ),
    ('name = "A"', "", "[[joint]] 1: the field 'name' is missing", "Give name a value"),
    ("inertia = [1, 1, 1]", "inertia = [1, 1]", "crank.toml, [[body]] 'crank': Body 'crank': inertia"),
    ('name = "A"', "name = 3", "[[joint]] 1: Joint: name 3"),
    # names of other parts
    (
        '"crank.center"',
        '"crank.centre"',
        "crank.toml: Joint 'A': marker 'crank.centre' does not exist",
        "Body 'crank' has: center",
        "Did you mean 'crank.center'?",
    ),
    # expressions
    (
        '"= mass"',
        '"= masss*2"',
        "crank.toml, [[body]] 'crank', mass: Expression 'masss*2': the name 'masss' is unknown",
        "Did you mean 'mass'?",
    ),
    (
        '"= mass"',
        '"= import os"',
        "[[body]] 'crank', mass: Expression 'import os': an expression that is not arithmetic",
    ),
    ('"= mass"', '"= 2*t"', "[[body]] 'crank': Body 'crank': mass = Expression("),
    ('mass = "= mass"', "mass = true", "[[body]] 'crank': Body 'crank': mass = True", "a number >"),
    # parameters
    (
        "mass = 2.0",
        'mass = "= mass2"\nmass2 = "= 2*mass"',
        "[parameters], mass",
        "the parameters depend on each other: mass -> mass2 -> mass",
        "Give one of them a number",
    ),
    (
        "mass = 2.0",
        'mass = "= maas + 1"\nmaas1 = 1',
        "crank.toml, [parameters], mass: Expression 'maas + 1': the name 'maas'",
        "Did you mean 'maas1'?",
    ),
    ("mass = 2.0", "t = 2.0", "[parameters], t: 't' is taken", "Choose another name"),
    ("mass = 2.0", "sin = 2.0", "[parameters], sin: 'sin' is taken"),
    ("mass = 2.0", '"a b" = 2.0', "[parameters], a b: 'a b' is not a name"),
    (
        "mass = 2.0",
        "mass = {a = 1}",
        "[parameters], mass: a value of type dict",
        "a number, a text or a list",
    ),
    ("mass = 2.0", "mass = 1979-05-27", "[parameters], mass: a value of type date"),
    ("[parameters]\nmass = 2.0", "parameters = 3", "[parameters]: it is no table", "single brackets"),
    # signals, objects, reduced bodies, materials
    (
        'mass = "= mass"',
        "mass = { ramp = { rat = 1 } }",
        "[[body]] 'crank', mass, ramp: there is no field 'rat'",
        "Ramp has: rate, rise, start",
        "Did you mean 'rate'?",
    ),
    (
        'mass = "= mass"',
        "mass = { ramp = { rise = 1 } }",
        "mass, ramp: the field 'rate' is missing",
        "Give rate a value",
    ),
    ('mass = "= mass"', "mass = { ramp = { rate = 1, rise = -1 } }", "mass, ramp: Signal ramp: rise = -1.0"),
    (
        'mass = "= mass"',
        'mass = { kind = "Steel" }',
        "[[body]] 'crank', mass: kind = 'Steel' is unknown",
        "Material",
    ),
    (
        'mass = "= mass"',
        'data = "levr.h5"',
        "[[body]] 'crank', data: the file 'levr.h5' does not exist",
        "the folder holds: lever.h5",
        "Did you mean 'lever.h5'?",
    ),
    (
        'mass = "= mass"',
        'data = "x/lever.h5"',
        "the file 'x/lever.h5' does not exist",
        "no .h5 file",
        "flexmb reduce",
    ),
    (
        'mass = "= mass"',
        'material = "stel"',
        "[[body]] 'crank', material: the material 'stel' is unknown",
        "steel, alu",
        "Did you mean 'steel'?",
    ),
    ('mass = "= mass"', 'material = "wood"', "the material 'wood' is unknown", 'kind = "Material"'),
    # gravity
    (
        "[parameters]",
        "gravity = 9.81\n[parameters]",
        "crank.toml: Model 'crank': gravity = 9.81",
        "three finite numbers",
    ),
]


@pytest.mark.parametrize(("old", "new", "messages"), [(a, b, m) for a, b, *m in CASES])
def test_messages(tmp_path, old, new, messages):
    assert GOOD.count(old) >= 1
    path = tmp_path / "crank.toml"
    path.write_text(GOOD.replace(old, new, 1))
    (tmp_path / "lever.h5").write_bytes(b"")
    with pytest.raises(ModelError) as caught:
        io.load_model(path)
    for message in messages:
        assert message in str(caught.value)


def test_the_good_file_is_good(tmp_path):
    path = tmp_path / "crank.toml"
    path.write_text(GOOD)
    assert io.load_model(path).body("crank").mass == 2.0


@pytest.mark.parametrize(
    ("name", "messages"),
    [
        ("crnk.toml", ("Model file", "does not exist", "The folder holds: crank.toml", "Correct the path")),
        ("nowhere/crank.toml", ("does not exist", "Folder:")),
        ("folder.toml", ("cannot be opened", "a readable text file")),
        ("lever.h5", ("it is not text in UTF-8", 'data = "lever.h5"')),
    ],
)
def test_files_that_cannot_be_read(tmp_path, name, messages):
    (tmp_path / "crank.toml").write_text(GOOD)
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "lever.h5").write_bytes(b"\x89HDF\xff\xfe")
    with pytest.raises(ModelError) as caught:
        io.load_model(tmp_path / name)
    for message in messages:
        assert message in str(caught.value)


def test_damaged_reduced_body(tmp_path):
    path = tmp_path / "crank.toml"
    path.write_text(GOOD.replace('mass = "= mass"', 'data = "lever.h5"', 1))
    (tmp_path / "lever.h5").write_bytes(b"nothing")
    with pytest.raises(DataFileError, match=r"lever\.h5"):
        io.load_model(path)


@pytest.mark.parametrize(
    ("settings", "messages"),
    [
        (
            {"mas": 1.0},
            (
                "crank.toml, [parameters]: there is no parameter 'mas' to set",
                "The file has: mass",
                "Did you mean 'mass'?",
            ),
        ),
        ({"length": 1.0}, ("there is no parameter 'length' to set", "Add length to [parameters]")),
        ({"mass": "= heavy"}, ("[parameters], mass", "the name 'heavy' is unknown")),
        ({"mass": -1.0}, ("[[body]] 'crank': Body 'crank': mass = -1.0", "a number >")),
        ({"mass": "heavy"}, ("[[body]] 'crank': Body 'crank': mass = 'heavy'",)),
    ],
)
def test_wrong_settings(tmp_path, settings, messages):
    path = tmp_path / "crank.toml"
    path.write_text(GOOD)
    with pytest.raises(ModelError) as caught:
        io.load_model(path, settings)
    for message in messages:
        assert message in str(caught.value)


@pytest.mark.parametrize(
    ("table", "messages"),
    [
        ("", ("crank.toml': the file is empty", "Write one")),
        ("# empty", ("crank.toml, [simulation]: the table is missing", "with t_end", "Add [simulation]")),
        ("simulation = 3", ("the table is missing",)),
        ("[simulation]\nsamples = 3", ("the field 't_end' is missing", "Give t_end a value")),
        ("[simulation]\nt_end = 0.0", ("Simulation: t_end = 0.0", "a positive duration")),
        ("[simulation]\nt_end = 1.0\nsamples = 1", ("samples = 1.", "at least 2")),
        ("[simulation]\nt_end = 1.0\nsamples = 2.5", ("samples = 2.5", "a whole number")),
        ("[simulation]\nt_end = 1.0\nsample = 5", ("there is no field 'sample'", "Did you mean 'samples'?")),
        (
            '[simulation]\nt_end = 1.0\nintegrator = "Euler"',
            (
                "[simulation], integrator: kind = 'Euler' is unknown",
                "One of: Explicit, GeneralizedAlpha, IDA, Implicit, MoreauJean.",
            ),
        ),
        (
            '[simulation]\nt_end = 1.0\nintegrator = { kind = "GeneralisedAlpha" }',
            ("One of: Explicit, GeneralizedAlpha, IDA, Implicit, MoreauJean.", "Did you mean 'GeneralizedAlpha'?"),
        ),
        (
            "[simulation]\nt_end = 1.0\nintegrator = { rho_inf = 0.9 }",
            ("integrator: the field 'kind' is missing", 'Write integrator = { kind = "GeneralizedAlpha", ... }'),
        ),
        (
            "[simulation]\nt_end = 1.0\nintegrator = { IDA = { rtol = 1e-6 } }",
            ("integrator: the field 'kind' is missing", 'Write integrator = { kind = "IDA", ... }'),
        ),
        (
            "[simulation]\nt_end = 1.0\nintegrator = {}",
            ("integrator: the field 'kind' is missing", 'Write integrator = { kind = "GeneralizedAlpha", ... }'),
        ),
        ('[simulation]\nt_end = 1.0\nstart = "rest"', ("start = 'rest'", '"equilibrium"', "Leave it out")),
        ("[simulation]\nt_end = 1.0\nintegrator = 3", ("integrator: 3", "as a text or in a table")),
    ],
)
def test_wrong_simulations(tmp_path, table, messages):
    path = tmp_path / "crank.toml"
    path.write_text(table)
    with pytest.raises(ModelError) as caught:
        io.load_simulation(path)
    for message in messages:
        assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("pressure=5.5e3", ("pressure", 5500.0)),
        ("a = 2*pi/2", ("a", 3.141592653589793)),
        ("file=lever.toml", ("file", "lever.toml")),
        ("a== 2*b", ("a", "= 2*b")),
        ("rigid=true", ("rigid", True)),
        ("rigid = false", ("rigid", False)),
    ],
)
def test_settings_of_the_command_line(text, found):
    assert io.parse_setting(text) == found


@pytest.mark.parametrize("text", ["pressure", "=3", "pressure=", ""])
def test_settings_without_name_or_value(text):
    with pytest.raises(
        ModelError, match=r"Setting '.*': no name and value. Expected: name=value. Write pressure=5.5e3"
    ):
        io.parse_setting(text)
