"""Campaigns over data files: reduced bodies, runs, exchange formats, meshes and matrices, damaged and used."""

from __future__ import annotations

import shutil
from functools import cache
from pathlib import Path

import numpy as np
from fuzz.campaign import Campaign
from fuzz.mutation import damaged, generator, mutant
from fuzz.probing import probed
from scipy import io as scipy_io
from scipy import sparse

import flexmb as fmb
from flexmb import fem, hdf5, hdf5_seal, io, reduction
from flexmb.results import RunFile
from flexmb.results.run_file import floating_data

__all__ = ["BODIES", "MATRICES", "MESHES", "RUNS", "TEXTS", "data_campaign", "reduced"]

ROOT = Path(__file__).parents[2]
STEEL = fmb.MATERIALS["steel"]

BODIES = ("body.h5", "stiffened.h5")
RUNS = ("run.h5", "cut.h5")
TEXTS = ("body.sid", "stiffened.sid", "body.fem", "stiffened.fem")
MESHES = (
    *("wedge15.msh", "wedge15.bdf", "wedge15.inp", "hexahedron20.msh", "bracket_hex8.msh", "bracket_hex8.bdf"),
    *("bracket_hex8.inp", "binary.msh", "ascii22.msh", "binary.vtu", "ascii.vtu", "binary.vtk", "ascii.vtk"),
)
MATRICES = (
    *("market/K.mtx", "market/M.mtx", "abaqus/block_STIF1.mtx", "abaqus/block_MASS1.mtx", "abaqus/block.inp"),
    *("ccx/block.sti", "ccx/block.mas", "ccx/block.dof", "ccx/block.inp", "nastran/beam.pch", "numpy/beam.npz"),
)
MARK = b"FLEXSEAL"
"""With this the seal begins, and the parity follows it."""
_MAIN = {"market": "K.mtx", "abaqus": "block_STIF1.mtx", "ccx": "block.sti", "nastran": "beam.pch", "numpy": "beam.npz"}


def data_campaign(name: str, names: tuple[str, ...], *, seed: int = 1, limit: float = 10.0) -> Campaign:
    """Return the campaign over damaged variants of the named files."""
    contents: dict[str, bytes] = {}

    def make(folder: Path, k: int) -> Path:
        original = folder / "originals" / names[k % len(names)]
        content = contents.setdefault(names[k % len(names)], original.read_bytes())
        case = folder / "case"
        shutil.rmtree(case, ignore_errors=True)
        if original.parent.name == "originals":
            case.mkdir()
        else:  # a set of files that are read together
            shutil.copytree(original.parent, case)
        change = damaged if original.suffix in (".h5", ".npz") else mutant
        if original.suffix == ".h5" and k % 3:  # a seal tells of any change: two of three are files without one
            content = content[: content.index(MARK)] + content[hdf5_seal.end_of(original) :]
        (case / original.name).write_bytes(change(content, generator(seed, k)))
        return case / original.name

    def warm(folder: Path) -> list[Path]:
        sound = folder / "sound"
        shutil.copytree(folder / "originals", sound)
        return [sound / name for name in names]

    return Campaign(name, lambda folder: _prepare(folder, names), make, use, limit=limit, warm=warm)


def use(path: Path) -> None:
    """Do with a data file what a user does."""
    hdf5.probe = probed
    suffix = path.suffix
    if (path.parent / _MAIN["market"]).is_file():
        nodes = np.random.default_rng(0).random((12, 3))
        fem.read_matrices(path.parent / "K.mtx", nodes, mass=path.parent / "M.mtx")
    elif (path.parent / _MAIN["abaqus"]).is_file():
        fem.read_matrices(path.parent / _MAIN["abaqus"], path.parent / "block.inp")
    elif (path.parent / _MAIN["ccx"]).is_file():
        fem.read_matrices(path.parent / _MAIN["ccx"])
    elif suffix in (".pch", ".npz"):
        fem.read_matrices(path)
    elif path.name in RUNS:
        _use_run(path)
    elif suffix == ".h5":
        _use_body(fmb.ModalNeutralData.load(path), path)
    elif suffix == ".sid":
        _use_body(io.read_sid(path), path)
    elif path.name in TEXTS:
        _use_body(io.read_mbdyn_fem(path), path)
    else:
        _use_mesh(fem.read_mesh(path), path)


def _use_body(data: fmb.ModalNeutralData, path: Path) -> None:
    data.report()
    repr(data)
    fmb.check(fmb.Model(bodies=[fmb.Ground(), fmb.FloatingBody("part", data=data)]))
    if len(data.nodes):
        io.write_modes(data, path.with_name("modes.pvd"))
    data.save(path.with_name("again.h5"))


def _use_run(path: Path) -> None:
    solution = fmb.Solution.load(path, read_model=fmb.read_model_text)
    str(solution.status)
    for phase in solution.phases:
        for sensor in phase.model.sensors if phase.model is not None else ():
            solution[sensor.name]
    io.write_vtk(solution, path.parent / "vtk" / "run.pvd")
    RunFile.continued(path).close()


def _use_mesh(mesh: fem.Mesh, path: Path) -> None:
    repr(mesh)
    if any(fem.meshes.mesh.DIMENSION[kind] == 3 for kind, _ in mesh.cells):
        fe = fem.solid(mesh, STEEL)
        abs(fe.K).max()
        fe.rigid_motions()


@cache
def reduced(stiffened: bool = False) -> fmb.ModalNeutralData:
    """Return a small reduced body."""
    fe = fem.solid(fem.read_mesh(ROOT / "meshes" / "bracket_hex8.msh"), STEEL)
    return reduction.reduce(
        fe,
        interfaces={"a": "foot", "b": "load"},
        modes=2,
        loads={"push": "load"},
        compare=0,
        geometric_stiffness=stiffened,
    )


def _prepare(folder: Path, names: tuple[str, ...]) -> None:
    """Write the undamaged files that are asked for."""
    originals = folder / "originals"
    originals.mkdir()
    if {*names} & {*BODIES, *TEXTS}:
        for name, body in (("body", reduced()), ("stiffened", reduced(True))):
            body.save(originals / f"{name}.h5")
            io.write_sid(body, originals / f"{name}.sid")
            io.write_mbdyn_fem(body, originals / f"{name}.fem")
    if {*names} & {*RUNS}:
        _runs(originals, reduced())
    if {*names} & {*MESHES}:
        _meshes(originals)
    if {*names} & {*MATRICES}:
        _matrices(originals)


def _runs(originals: Path, data: fmb.ModalNeutralData) -> None:
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"A": (0, 0, 0)}),
            fmb.FloatingBody("part", data=data, at=(-0.05, -0.03, 0)),
            fmb.PointMass("m", mass=1.0),
        ],
        joints=[fmb.Revolute("hinge", markers=("ground.A", "part.a"))],
        sensors=[fmb.Position("place", marker="m.center"), fmb.Reaction("force", joint="hinge")],
    )
    for name in RUNS:
        with RunFile(originals / name, floating_data(model)) as run:
            run.begin(io.model_text(model))
            solution = fmb.simulate(model, t_end=0.01, samples=4)
            phase = solution.phases[0]
            run.append(*(getattr(phase, field) for field in ("t", "q", "u", "a", "lam", "works")))
            if name != "cut.h5":
                run.end("finished", {s.name: solution[s.name] for s in model.sensors}, {"place": ("x", "y", "z")})
                run.finish(solution.status, {"steps": 3})


def _meshes(originals: Path) -> None:
    import meshio

    for name in MESHES:
        for source in (ROOT / "tests" / "data" / "mesh" / name, ROOT / "meshes" / name):
            if source.is_file():
                shutil.copy(source, originals / name)
    box = meshio.Mesh(
        np.array([[x, y, z] for z in (0, 1.0) for y in (0, 1.0) for x in (0, 1.0)]),
        [("hexahedron", np.array([[0, 1, 3, 2, 4, 5, 7, 6]])), ("quad", np.array([[0, 1, 3, 2]]))],
        cell_data={"part": [np.array([1]), np.array([2])]},
        point_data={"clamped": np.arange(8) % 2},
    )
    tagged = meshio.Mesh(
        box.points,
        box.cells,
        cell_data={name: [np.array([1]), np.array([2])] for name in ("gmsh:physical", "gmsh:geometrical")},
        field_data={"block": np.array([1, 3]), "foot": np.array([2, 2])},
    )
    meshio.gmsh.write(originals / "ascii22.msh", tagged, fmt_version="2.2", binary=False)
    meshio.gmsh.write(originals / "binary.msh", tagged, fmt_version="2.2", binary=True)
    meshio.vtu.write(originals / "binary.vtu", box, binary=True)
    meshio.vtu.write(originals / "ascii.vtu", box, binary=False)
    meshio.vtk.write(originals / "binary.vtk", box, binary=True)
    meshio.vtk.write(originals / "ascii.vtk", box, binary=False)


def _matrices(originals: Path) -> None:
    source = ROOT / "meshes" / "matrices"
    for folder in _MAIN:
        (originals / folder).mkdir()
    for name in ("block_STIF1.mtx", "block_MASS1.mtx", "block.inp"):
        shutil.copy(source / name, originals / "abaqus")
    shutil.copy(source / "block.inp", originals / "ccx")
    shutil.copy(source / "block_K.mtx", originals / "market" / "K.mtx")
    shutil.copy(source / "block_M.mtx", originals / "market" / "M.mtx")
    shutil.copy(source / "beam.pch", originals / "nastran")
    shutil.copy(source / "beam.npz", originals / "numpy")
    for symbol, suffix in (("K", "sti"), ("M", "mas")):
        upper = sparse.triu(sparse.coo_matrix(scipy_io.mmread(source / f"block_{symbol}.mtx"))).tocoo()
        rows = [f"{i + 1} {j + 1} {value:.17e}" for i, j, value in zip(upper.row, upper.col, upper.data)]
        (originals / "ccx" / f"block.{suffix}").write_text("\n".join(rows) + "\n")
    (originals / "ccx" / "block.dof").write_text("\n".join(f"{n}.{d}" for n in range(1, 13) for d in (1, 2, 3)) + "\n")
