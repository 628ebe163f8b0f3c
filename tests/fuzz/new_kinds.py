"""Campaigns over model files with blocks, profiles, shapes, laws, parts; over surface meshes; over foreign units."""

from __future__ import annotations

import io as streams
import os
import random
import shutil
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np
from contracts.every_description import DESCRIPTIONS, model_of
from fmi.exchange_units import write_without_library
from fuzz import model_files
from fuzz.campaign import Campaign
from fuzz.mutation import damaged, generator, mutant

import flexmb as fmb
from flexmb import io, system

__all__ = ["described_campaign", "surface_campaign", "unit_campaign"]

PART = """
gravity = [0, 0, -9.81]
[[body]]
kind = "Ground"
markers = { A = [0, 0, 0] }
[[body]]
kind = "FloatingBody"
name = "bar"
[body.data]
modes = 2
compare = 0
interfaces = { a = "start", b = "end" }
stations = { m = "mid" }
loads = { f = { kind = "Forces", on = "mid", force = [0, 0, 1.0] } }
[[body.data.pieces]]
kind = "Line"
points = [[0, 0, 0], [1.0, 0, 0]]
section = { kind = "Section.rectangle", width = 0.02, height = 0.03 }
material = "steel"
elements = 4
nodes = { mid = 0.5 }
[[body.data.masses]]
kind = "Mass"
at = "mid"
mass = 1.0
[[joint]]
kind = "Revolute"
name = "hinge"
markers = ["ground.A", "bar.a"]
"""
SHAPES = ("ascii.stl", "binary.stl", "solid.obj", "ascii.ply", "binary.ply", "solid.off", "solid.vtk", "solid.vtu")

UNITS = ("cosimulation2", "cosimulation3", "exchange2", "exchange3")


def described_campaign(*, seed: int = 1, limit: float = 10.0) -> Campaign:
    """Return the campaign over model files with what `contracts.every_description` has, and with a described part."""
    names: list[str] = []

    def prepare(folder: Path) -> None:
        os.environ["FLEXMB_BODIES"] = str(folder / "bodies")
        (folder / "part.seed").write_text(PART)
        for name in DESCRIPTIONS:
            try:
                model = model_of(name)
                if model is not None:
                    io.save_model(model, folder / f"{name}.toml")
            except fmb.ModelError:  # functions stand in no file
                continue
            if (folder / f"{name}.toml").is_file():
                (folder / f"{name}.toml").rename(folder / f"{name}.seed")

    def make(folder: Path, k: int) -> Path:
        if not names:
            names.extend(sorted(path.name for path in folder.glob("*.seed")))
        path = folder / "case.toml"
        path.write_bytes(mutant((folder / names[k % len(names)]).read_bytes(), generator(seed, k), values=True))
        return path

    def warm(folder: Path) -> list[Path]:
        return [shutil.copy(path, path.with_suffix(".warm.toml")) for path in sorted(folder.glob("*.seed"))]

    return Campaign("described", prepare, make, _use_model, limit=limit, warm=warm)


def _use_model(path: Path) -> None:
    model_files.use(path)
    system.compile(io.load_model(path))


def surface_campaign(*, seed: int = 1, limit: float = 10.0) -> Campaign:
    """Return the campaign over damaged meshes of surfaces."""

    def make(folder: Path, k: int) -> Path:
        original = folder / "originals" / SHAPES[k % len(SHAPES)]
        change = damaged if original.name.startswith("binary") and k % 2 else mutant
        path = folder / original.name
        path.write_bytes(change(original.read_bytes(), generator(seed, k)))
        return path

    return Campaign("surfaces", _solids, make, _use_surface, limit=limit, warm=lambda f: [f / "originals" / SHAPES[0]])


def _use_surface(path: Path) -> None:
    shape = fmb.TriangleMesh(file=path)
    surface = fmb.Surface("solid", marker="stone.center", shape=shape, spacing=max(0.3 * shape.reach, 1e-12))
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("stone", mass=1.0, inertia=(1.0, 1.0, 1.0))],
        surfaces=[fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()), surface],
        forces=[
            fmb.SurfaceContact(
                "touch", surfaces=("floor", "solid"), law=fmb.ElasticFoundation(modulus=1e6, thickness=0.1)
            )
        ],
    )
    fmb.accelerations(model)
    bool(shape.convex)
    shape.drawing()


def _solids(folder: Path) -> None:
    """Write one solid, an irregular octahedron, in every format."""
    import meshio

    originals = folder / "originals"
    originals.mkdir()
    points = np.array([[1, 0, 0], [-1, 0, 0], [0, 1.2, 0], [0, -1, 0], [0, 0, 1.5], [0, 0, -1.0]])
    cells = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    mesh = meshio.Mesh(points, [("triangle", np.array(cells))])
    for name, options in (
        *(("ascii.stl", {"binary": False}), ("binary.stl", {"binary": True}), ("solid.obj", {})),
        *(("ascii.ply", {"binary": False}), ("binary.ply", {"binary": True}), ("solid.vtk", {"binary": False})),
        ("solid.vtu", {"binary": False}),
    ):
        meshio.write(originals / name, mesh, **options)
    rows = [" ".join(map(str, p)) for p in points] + [f"3 {a} {b} {c}" for a, b, c in cells]
    (originals / "solid.off").write_text("OFF\n" + f"{len(points)} {len(cells)} 0\n" + "\n".join(rows) + "\n")


def unit_campaign(*, seed: int = 1, limit: float = 10.0) -> Campaign:
    """Return the campaign over damaged units of FMI: bytes of the archive, and texts within a sound one."""

    def make(folder: Path, k: int) -> Path:
        rng, original = generator(seed, k), folder / f"{UNITS[k % len(UNITS)]}.seed"
        path = folder / f"{original.stem}.fmu"
        content = original.read_bytes()
        path.write_bytes(damaged(content, rng) if k % 3 == 0 else _with_other_text(content, rng))
        return path

    def warm(folder: Path) -> list[Path]:
        return [shutil.copy(folder / f"{name}.seed", folder / f"{name}.fmu") for name in UNITS]

    return Campaign("units", _units, make, _use_unit, limit=limit, warm=warm)


def _with_other_text(content: bytes, rng: random.Random) -> bytes:
    """Return an archive whose description is damaged, with right checksums; the code in it stays away."""
    out = streams.BytesIO()
    with zipfile.ZipFile(streams.BytesIO(content)) as old, zipfile.ZipFile(out, "w") as new:
        for file in old.infolist():
            text = old.read(file)
            new.writestr(file.filename, mutant(text, rng) if file.filename == "modelDescription.xml" else text)
    return out.getvalue()


def _units(folder: Path) -> None:
    """Write units of both versions without their libraries: what is damaged is not to be run."""
    place = fmb.JointCoordinate("place", joint="rail")
    light = fmb.RigidBody("cart", mass=1.0, inertia=(1, 1, 1))
    model = fmb.Model(
        bodies=[fmb.Ground(), light],
        joints=[fmb.Prismatic("rail", markers=("ground.origin", "cart.center"))],
        forces=[fmb.Actuator("push", joint="rail", effort=fmb.input("force", 1.0))],
        sensors=[place],
    )
    for version in (2, 3):
        made = fmb.fmi.write_fmu(model, folder / "made.fmu", version=version)
        with zipfile.ZipFile(made) as old, zipfile.ZipFile(folder / f"cosimulation{version}.seed", "w") as new:
            for file in old.infolist():
                library = file.filename.startswith("binaries/") and not file.is_dir()
                new.writestr(file.filename, b"no library" if library else old.read(file))
        write_without_library(folder / f"exchange{version}.seed", "oscillator", version)


def _use_unit(path: Path) -> None:
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("m", mass=1.0)],
        forces=[fmb.PointLoad("push", marker="m.center", force=(fmb.input("force"), 0, 0))],
        sensors=[fmb.Position("x", marker="m.center")],
    )
    if path.stem.startswith("exchange"):
        with suppress(fmb.FlexmbError):
            fmb.fmi.ModelExchange(path, inputs={"u": fmb.expression("t")})
        unit = fmb.fmi.Fmu(path, inputs={"u": "x x"}, outputs={"force": "y"}, kind="model exchange")
    else:
        unit = fmb.fmi.Fmu(path, inputs={"force": "x x"}, outputs={"force": "place"})
    fmb.fmi.cosimulate(model, unit, 0.01, step=0.01)
