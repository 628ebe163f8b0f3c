"""`flexmb reduce`: a mesh file becomes a flexible body."""

from pathlib import Path

import pytest

import flexmb as fmb
from flexmb.cli import main

MESH = str(Path(__file__).parents[2] / "meshes" / "bracket_hex8.msh")
CONROD = str(Path(__file__).parents[2] / "meshes" / "conrod.msh")


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_reduce(capsys):
    arguments = [
        "reduce",
        MESH,
        "--material",
        "aluminium",
        "--interface",
        "a=foot",
        "--interface",
        "b=load",
        "--modes",
        "4",
        "--station",
        "s=0.01,0.01,0.0",
        "-o",
        "bracket.h5",
    ]
    assert main(arguments) == 0
    data = fmb.ModalNeutralData.load("bracket.h5")
    assert data.marker_names == ("a", "b", "s")
    assert data.n_modes == 2 * 6 + 4 - 6
    printed = capsys.readouterr().out
    assert f"mass {data.mass:.6g} kg" in printed
    assert "markers: a, b, s" in printed
    assert "Written: bracket.h5" in printed


def test_basis_and_bound(capsys):
    places = ["--interface", "a=foot", "--interface", "b=load", "--material", "aluminium", "--no-stress"]
    asked = ["--basis", "Krylov frequencies=0,500", "--error-up-to", "2000"]
    assert main(["reduce", MESH, *places, *asked, "-o", "bracket.h5"]) == 0
    data = fmb.ModalNeutralData.load("bracket.h5")
    assert data.quality["basis"].startswith("Krylov(frequencies=(0.0, 500.0)")
    assert data.quality["transfer"]["frequencies"][-1] == 2000.0
    assert "Response to loads up to 2000 Hz" in capsys.readouterr().out
    assert main(["reduce", MESH, *places, "--basis", "MacNeal", "-o", "other.h5"]) == 2
    assert "basis='Rubin'" in capsys.readouterr().err


def test_every_option(capsys):
    """A mesh in mm; the material in numbers; a coupling at the nodes themselves; modes by accuracy."""
    arguments = [
        "reduce",
        MESH,
        "--material",
        "young=70e9, poisson=0.3, density=2700",
        "--interface",
        "foot=foot",
        "--interface",
        "n=nodes:17",
        "--interface",
        "mean=averaging:load",
        "--load",
        "push=load",
        "--modes",
        "up to 5 kHz within 5 %",
        "--scale",
        "2",
        "--frame",
        "foot",
        "--geometric-stiffness",
        "--no-stress",
    ]
    assert main(arguments) == 0
    data = fmb.ModalNeutralData.load("bracket_hex8.h5")
    assert data.mass == pytest.approx(1.006 / 7850 * 2700 * 8, rel=1e-3)
    assert data.load_names == ("push",)
    assert data.frame == "foot"
    assert data.geometric is not None
    assert data.stress_modes is None
    assert "loads: push" in capsys.readouterr().out


@pytest.mark.parametrize("thickness", [["0.002"], ["skin=0.002", "rib=0.004"]], ids=["one", "groups"])
def test_shells(thickness, capsys):
    """A plate 0.4 m x 0.1 m, half skin and half rib: mass by hand, freedoms of two bare nodes and four modes."""
    import meshio
    import numpy as np

    x, y = np.meshgrid(np.linspace(0, 0.4, 9), np.linspace(0, 0.1, 3), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    number = np.arange(x.size).reshape(x.shape)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], -1).reshape(-1, 4)
    tags = np.where(points[quads].mean(axis=1)[:, 0] < 0.2, 1, 2)
    mesh = meshio.Mesh(
        points,
        [("quad", quads)],
        cell_data={"gmsh:physical": [tags], "gmsh:geometrical": [tags]},
        field_data={"skin": np.array([1, 2]), "rib": np.array([2, 2])},
    )
    mesh.write("plate.msh", file_format="gmsh22", binary=False)
    options = [word for text in thickness for word in ("--thickness", text)]
    steel = ["--material", "steel"]
    assert (
        main(["reduce", "plate.msh", *steel, *options, "--interface", "a=0", "--interface", "b=26", "--modes", "4"])
        == 0
    )
    data = fmb.ModalNeutralData.load("plate.h5")
    assert data.mass == pytest.approx(7850 * 0.04 * (0.002 if len(thickness) == 1 else 0.003), rel=1e-9)
    assert data.n_modes == 2 * 6 + 4 - 6
    assert "Written: plate.h5" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "messages"),
    [
        (["none.msh", "--interface", "a=foot"], ("none.msh",)),
        (
            [MESH],
            ("no --interface", "at least one place where joints act", "Add --interface a=NAME_OF_A_SET"),
        ),
        ([MESH, "--interface", "foot"], ("--interface foot: no NAME=WHERE", "Write --interface a=bore_a")),
        (
            [MESH, "--interface", "a=foot", "--interface", "a=load"],
            ("--interface a=load: a name that is used twice",),
        ),
        (
            [CONROD, "--interface", "big=conrod"],
            ("Interface 'big': 'conrod' selects all", "Name a surface of the part", "averaging:GROUP"),
        ),
        ([MESH, "--interface", "a=fot"], ("the group 'fot' does not exist", "Did you mean 'foot'?")),
        (
            [MESH, "--interface", "a=foot", "--material", "stel"],
            ("--material: 'stel' is unknown", "Did you mean 'steel'?"),
        ),
        (
            [MESH, "--interface", "a=foot", "--material", "young=1,density=2"],
            ("numbers for young, poisson and density", "Write young=210e9"),
        ),
        (
            [MESH, "--interface", "a=foot", "--material", "young=1,poisson=x,density=2"],
            ("numbers for young, poisson",),
        ),
        (
            [MESH, "--interface", "a=foot", "--material", "young=-1,poisson=0.3,density=2"],
            ("young = -1.0 Pa",),
        ),
        ([MESH, "--interface", "a=foot", "--modes", "many"], ("modes = 'many'", "a count")),
        ([MESH, "--interface", "a=foot", "--thickness", "thin"], ("--thickness: thin", "Write --thickness 0.002")),
        ([MESH, "--interface", "a=foot", "--thickness", "1", "--thickness", "a=2"], ("--thickness: 1 a=2",)),
        ([MESH, "--interface", "a=foot", "--scale", "0"], ("--scale: 0.0", "a factor > 0")),
    ],
)
def test_errors_are_messages(arguments, messages, capsys):
    steel = [] if "--material" in arguments else ["--material", "steel"]
    assert main(["reduce", *arguments, *steel]) == 2
    written = capsys.readouterr().err
    assert written.startswith("flexmb reduce: ")
    for message in messages:
        assert message in written


def test_the_material_must_be_said(capsys):
    assert main(["reduce", MESH, "--interface", "a=foot"]) == 2
    written = capsys.readouterr().err
    assert "no --material" in written
    assert "Add --material steel" in written
    assert not list(Path().iterdir())


def test_a_body_is_replaced_only_when_asked(capsys):
    command = ["reduce", MESH, "--interface", "a=foot", "--modes", "1", "--no-report", "-o", "b.h5", "--material"]
    assert main([*command, "steel"]) == 0
    before = Path("b.h5").read_bytes()
    assert main([*command, "aluminium"]) == 2
    assert "Reduced body 'b.h5': the file exists already" in capsys.readouterr().err
    assert Path("b.h5").read_bytes() == before
    assert main([*command, "aluminium", "--overwrite"]) == 0
    assert fmb.ModalNeutralData.load("b.h5").mass == pytest.approx(1.006 / 7850 * 2800, rel=1e-3)


def test_a_track_and_a_basis_of_a_run_are_named(capsys):
    """The track has a shape for each node; wrong words are named before the mesh is read."""
    nodes = "\n".join(f"{k + 1}, {0.1 * k}, 0., 0." for k in range(9))
    bars = "\n".join(f"{k + 1}, {k + 1}, {k + 2}" for k in range(8))
    section = "*BEAM SECTION, ELSET=ALL, MATERIAL=S, SECTION=RECT\n0.02, 0.03\n0., 0., 1."
    material = "*MATERIAL, NAME=S\n*ELASTIC\n7e10, 0.3\n*DENSITY\n2700."
    sets = "*NSET, NSET=RAIL, GENERATE\n2, 8, 1"
    text = f"*NODE\n{nodes}\n*ELEMENT, TYPE=B31, ELSET=ALL\n{bars}\n{sets}\n{section}\n{material}\n"
    Path("bar.inp").write_text(text, encoding="utf-8")
    ends = ["--interface", "a=node 1", "--modes", "0", "--no-report", "-o", "rail.h5"]
    assert main(["reduce", "bar.inp", *ends, "--track", "rail=RAIL:0,0,-1"]) == 0
    data = fmb.ModalNeutralData.load("rail.h5")
    track = data.quality["tracks"]["rail"]
    assert len(track["loads"]) == len(data.load_names) == 7
    assert track["places"][-1] == pytest.approx(0.6)
    assert track["shapes"] >= 1
    assert "7 nodes, 0.6 m, (0.1, 0, 0) to (0.7, 0, 0)" in data.report()
    places = ["--interface", "a=foot", "--material", "aluminium", "--no-stress", "--no-report", "--modes", "0"]
    for wrong, words in (
        (["--track", "rail=load:0,0,-1"], "Name the nodes of one line"),
        (["--track", "rail=load:0,x,1"], "--track rail"),
        (["--track", "rail=load", "--load", "rail=load"], "--load"),
        (["--basis", "Pod energy=0.9"], "Pod run=first/solution.h5#beam"),
        (["--basis", "Pod run=absent.h5#beam"], "absent.h5"),
    ):
        assert main(["reduce", MESH, *places, *wrong, "-o", "other.h5"]) == 2
        assert words in capsys.readouterr().err
