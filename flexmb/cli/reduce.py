"""Reduce a meshed part to a flexible body.

Example: flexmb reduce conrod.msh --material steel --interface a=bore_a --interface b=bore_b --modes 12 -o conrod.h5
A deck brings its own materials and interfaces: flexmb reduce wing.bdf --units "mm, t, s"
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import flexmb as fmb
from flexmb.cli.mesh_argument import require_mesh
from flexmb.cli.progress import ProgressBar
from flexmb.errors import ModelError, did_you_mean

NAME = "reduce"
SUMMARY = "reduce a meshed part to a flexible body (.h5)"


COUPLINGS = {"rigid": "Rigid", "averaging": "Averaging", "nodes": "Nodes"}
"""How an interface follows its nodes: ``--interface a=averaging:bore_a``."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "mesh",
        help="mesh file (Gmsh .msh, Nastran .bdf, Abaqus .inp, .vtu) with --material, or "
        "a whole deck of Nastran, Abaqus or CalculiX without",
    )
    parser.add_argument(
        "--material",
        metavar="NAME",
        help="steel, aluminium, titanium, or young=...,poisson=...,density=... in SI units; a deck brings its own",
    )
    parser.add_argument(
        "--units",
        metavar="UNITS",
        help='units of a deck, which does not state them: "mm, t, s"; "mm, kg, ms"; "in, lbf s2/in, s"; "m, kg, s"',
    )
    parser.add_argument(
        "--consistent-mass",
        action="store_true",
        help="do not lump the masses of a deck's elements at their nodes, as Nastran does without PARAM, COUPMASS",
    )
    parser.add_argument(
        "--stress-side",
        type=float,
        metavar="SIDE",
        help="side of shells whose stress is kept: 1 top, -1 bottom, 0 middle (default, with a warning): no bending",
    )
    parser.add_argument(
        "--thickness",
        action="append",
        default=[],
        metavar="T",
        help="the triangles and quadrilaterals of the mesh are shells of this thickness, in m; GROUP=T, repeated, for "
        "the groups of the mesh",
    )
    _add_points(parser)
    _add_basis(parser)
    parser.add_argument(
        "--scale",
        type=float,
        default=1.0,
        metavar="FACTOR",
        help="metres per unit of the mesh: 0.001 for a mesh in mm",
    )
    parser.add_argument(
        "--frame", default="buckens", help="buckens (default), or the interface that holds the body frame"
    )
    parser.add_argument("--geometric-stiffness", action="store_true", help="stiffening by loads and rotation")
    parser.add_argument("--no-stress", action="store_true", help="leave out stress modes: a smaller file")
    parser.add_argument("--no-report", action="store_true", help="do not write the report (.html, .json) beside it")
    parser.add_argument("-o", "--out", metavar="FILE", help="file to write; default: <mesh>.h5")
    parser.add_argument("--overwrite", action="store_true", help="replace the body that the file holds")


def _add_points(parser: argparse.ArgumentParser) -> None:
    """Add what says where the body is held, observed and loaded."""
    parser.add_argument(
        "--interface",
        action="append",
        default=[],
        metavar="NAME=WHERE",
        help="where joints and forces act: a named set, a node number (of a deck: its own), or x,y,z; repeat for "
        "each; NAME alone for a reference point of a deck, all of them by default. "
        "averaging:WHERE takes the mean of the nodes instead of tying them rigidly, nodes:WHERE keeps them bare",
    )
    parser.add_argument(
        "--station",
        action="append",
        default=[],
        metavar="NAME=WHERE",
        help="observed point: a named set, a node number, or x,y,z in m",
    )
    parser.add_argument(
        "--load",
        action="append",
        default=[],
        metavar="NAME=SURFACE",
        help="load shape: unit pressure onto a named surface, against its outward normal",
    )


def _add_basis(parser: argparse.ArgumentParser) -> None:
    """Add what says which displacements the body has."""
    parser.add_argument(
        "--track",
        action="append",
        default=[],
        metavar="NAME=SET[:X,Y,Z]",
        help="a line of nodes over which a load moves, and the direction of its force (default 0,0,1): its static "
        "responses join the basis",
    )
    parser.add_argument(
        "--modes",
        default="usual",
        help='number of normal modes (default 12), or "up to 200 Hz within 1 %%" (of the response), or "up to 200 Hz '
        'within 1 %% of the frequencies" (CraigBampton only)',
    )
    parser.add_argument(
        "--basis",
        default="CraigBampton",
        help='CraigBampton (default), Rubin, "Krylov frequencies=0,120 order=2", "CharacteristicModes '
        'interface_modes=30", Balanced, or "Pod run=solution.h5#beam energy=0.9999": what that body did in a run',
    )
    parser.add_argument(
        "--error-up-to",
        type=float,
        metavar="HZ",
        help="bound the error of the response to loads on the interfaces up to this frequency",
    )


def execute(arguments: argparse.Namespace) -> int:
    from flexmb import fem, io, reduction

    require_mesh(Path(arguments.mesh))
    deck = _is_deck(arguments)
    words = [f"{word}={word}" if deck and "=" not in word else word for word in arguments.interface]
    named = _named(words, "--interface")
    stations, loads = (_named(getattr(arguments, word), f"--{word}") for word in ("station", "load"))
    if deck:  # numbers belong to the deck, never to rows of a table that nobody sees
        named, stations = ({name: _of_deck(where) for name, where in own.items()} for own in (named, stations))
    loads |= _tracks(arguments.track, loads)
    interfaces: dict[str, Any] | str = named if named or not deck else "all"
    thickness = _thickness(arguments.thickness)
    if not arguments.scale > 0.0:
        raise ModelError(
            "--scale",
            found=f"{arguments.scale}",
            expected="a factor > 0: metres per unit of the mesh",
            remedy="Write --scale 0.001 for a mesh in mm",
        )
    if not interfaces:
        raise ModelError(
            "flexmb reduce",
            found="no --interface",
            expected="at least one place where joints act",
            remedy="Add --interface a=NAME_OF_A_SET",
        )
    material = None if deck else _material(arguments.material)
    out = _target(arguments)
    with ProgressBar() as progress:
        progress("reading the mesh", 0.0)
        if material is None:
            fe = fem.read_deck(
                arguments.mesh,
                units=arguments.units,
                lumped=False if arguments.consistent_mass else None,
                stress_side=arguments.stress_side,
            )
        else:
            mesh = fem.read_mesh(arguments.mesh, scale=arguments.scale)
            side = arguments.stress_side
            fe = fem.shell(mesh, material, thickness, stress_side=side) if thickness else fem.solid(mesh, material)
        data = reduction.reduce(
            fe,
            interfaces=interfaces,
            modes=_modes(arguments.modes),
            basis=_basis(arguments.basis),
            error_up_to=arguments.error_up_to,
            stations=stations,
            loads=loads,
            frame=arguments.frame,
            geometric_stiffness=arguments.geometric_stiffness,
            stress=not arguments.no_stress,
            progress=progress,
        )
    out = data.save(out)
    print(data.report())
    print()
    print(_summary(data, out))
    if not arguments.no_report:
        page, numbers = io.write_report(data, out)
        print(f"Report: {page}, {numbers}")
    return 0


def _is_deck(arguments: argparse.Namespace) -> bool:
    """Whether the file is to be read as a whole deck: no material is given, and it is of a kind that brings its own.

    ModelError where options of plain meshes and of decks contradict each other.
    """
    from flexmb import fem

    deck = arguments.material is None and Path(arguments.mesh).suffix.lower() in fem.DECK_READERS
    wrong = ""
    if deck and (arguments.thickness or arguments.scale != 1.0):
        wrong = "--thickness or --scale for a deck"
    elif not deck and arguments.stress_side is not None and not arguments.thickness:
        wrong = "--stress-side for solids"
    elif not deck and (arguments.units or arguments.consistent_mass):
        wrong = "--units or --consistent-mass for a plain mesh"
    if wrong:
        raise ModelError(
            "flexmb reduce",
            found=wrong,
            expected="--material, --thickness and --scale with a plain mesh, --units and --consistent-mass with a deck",
            remedy='Add --material steel to read the mesh alone, or write --units "mm, t, s" for the deck',
        )
    return deck


def _target(arguments: argparse.Namespace) -> Path:
    """Return the file to write; ModelError where that would replace a body unasked, before hours of reduction."""
    out = Path(arguments.out or Path(arguments.mesh).with_suffix(".h5").name)
    if out.exists() and not arguments.overwrite:
        raise ModelError(
            f"Reduced body '{out}'",
            found="the file exists already",
            expected="a new file",
            remedy="Give another one with -o, or --overwrite to replace it",
        )
    return out


def _material(text: str | None) -> fmb.Material:
    if text is None:
        raise ModelError(
            "flexmb reduce",
            found="no --material",
            expected=f"one of {', '.join(fmb.MATERIALS)}, or numbers",
            remedy="Add --material steel, or --material young=210e9,poisson=0.3,density=7850; the mesh file does not "
            "give it",
        )
    if "=" not in text:
        if text not in fmb.MATERIALS:
            raise ModelError(
                "--material",
                found=f"'{text}' is unknown",
                expected=f"One of: {', '.join(fmb.MATERIALS)}",
                remedy=did_you_mean(text, fmb.MATERIALS) or "Write young=210e9,poisson=0.3,density=7850",
            )
        return fmb.MATERIALS[text]
    values = _named(text.split(","), "--material")
    fields = ("young", "poisson", "density")
    if set(values) != set(fields) or not all(isinstance(value, int | float) for value in values.values()):
        raise ModelError(
            "--material",
            found=f"'{text}'",
            expected="numbers for young, poisson and density, each once",
            remedy="Write young=210e9,poisson=0.3,density=7850",
        )
    return fmb.Material(**{name: float(value) for name, value in values.items()})


def _thickness(texts: list[str]) -> float | dict[str, float] | None:
    """Return the thickness of shells, m, by groups where they are named; None for solids."""
    if not texts:
        return None
    values = {text.partition("=")[0] if "=" in text else "": _number(text.rpartition("=")[2]) for text in texts}
    numbers = all(isinstance(value, float) for value in values.values())
    if len(values) < len(texts) or not numbers or ("" in values and len(values) > 1):
        raise ModelError(
            "--thickness",
            found=" ".join(texts),
            expected="one number, m, or GROUP=T once for each group",
            remedy="Write --thickness 0.002, or --thickness skin=0.002 --thickness rib=0.003",
        )
    return values.get("", values)


def _named(texts: list[str], option: str) -> dict[str, Any]:
    """Return name -> set name, node numbers, number or coordinates of arguments ``name=where``."""
    named: dict[str, Any] = {}
    for text in texts:
        name, equals, where = (piece.strip() for piece in text.partition("="))
        if not equals or not name or not where or name in named:
            raise ModelError(
                f"{option} {text}",
                found="a name that is used twice" if name in named else "no NAME=WHERE",
                expected="NAME=WHERE, each name once",
                remedy=f"Write {option} a=bore_a",
            )
        named[name] = _place(where) if option != "--material" else _number(where)
    return named


def _place(text: str) -> Any:
    """Return coordinates (tuple) for "x,y,z", node numbers (list) for "17", else the name of a set.

    A coupling before a colon, "averaging:bore_a", wraps it.
    """
    from flexmb import reduction

    coupling, colon, where = text.partition(":")
    if colon and coupling in COUPLINGS:
        return getattr(reduction, COUPLINGS[coupling])(_place(where))
    numbers = [_number(piece) for piece in text.split(",")]
    if len(numbers) == 3 and all(isinstance(number, float) for number in numbers):
        return tuple(numbers)
    return [int(text)] if text.isdigit() else text


def _tracks(texts: list[str], loads: dict[str, Any]) -> dict[str, Any]:
    """Return the tracks of arguments ``name=set:x,y,z`` by name."""
    from flexmb import reduction

    found: dict[str, Any] = {}
    for name, where in _named(texts, "--track").items():
        line, colon, along = where.partition(":") if isinstance(where, str) else (where, "", "")
        direction = [_number(piece) for piece in along.split(",")] if colon else [0.0, 0.0, 1.0]
        if len(direction) != 3 or not all(isinstance(x, float) for x in direction) or name in loads:
            raise ModelError(
                f"--track {name}",
                found="the name of a --load" if name in loads else f"the direction '{along}'",
                expected="NAME=SET:X,Y,Z, a name of its own",
                remedy="Write --track rail=rail_nodes:0,0,-1",
            )
        found[name] = reduction.Track(line, tuple(direction))
    return found


def _basis(text: str) -> Any:
    """Return the basis that is named; what a body did in a run becomes the snapshots of `Pod`."""
    from flexmb import io, reduction

    words = text.split()
    if not words or words[0].lower() != "pod":
        return text
    given = dict(word.partition("=")[::2] for word in words[1:])
    path, _, body = given.pop("run", "").partition("#")
    energy = _number(given.pop("energy", "0.9999"))
    statics = given.pop("statics", "false").lower()
    if not path or not body or given or not isinstance(energy, float) or statics not in ("true", "false"):
        raise ModelError(
            "--basis Pod",
            found=f"'{text}'",
            expected="the file of a run and the body in it; energy and statics if wanted",
            remedy='Write --basis "Pod run=first/solution.h5#beam energy=0.9999 statics=false"',
        )
    motion = io.motion_of(path, body, fmb.read_model_text)
    return reduction.Pod(motion, energy=energy, statics=statics == "true")


def _of_deck(where: Any) -> Any:
    """Return a place; a bare node number is read as the deck's."""
    inner = getattr(where, "where", where)
    if not (isinstance(inner, list) and len(inner) == 1):
        return where
    text = f"node {inner[0]}"
    return text if inner is where else replace(where, where=text)


def _number(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text


def _modes(text: str) -> int | str:
    return int(text) if text.strip().isdigit() else text


def _summary(data: fmb.ModalNeutralData, out: Path) -> str:
    rounding = 1e-12 * max(abs(x) for x in data.center_of_mass)
    c = ", ".join(f"{0.0 if abs(x) <= rounding else x:.6g}" for x in data.center_of_mass)
    listed = ", ".join(f"{f:.4g}" for f in data.frequencies[:10]) + (", ..." if data.n_modes > 10 else "")
    return "\n".join(
        [
            f"{len(data.nodes)} nodes, mass {data.mass:.6g} kg, centre of mass ({c}) m",
            f"markers: {', '.join(data.marker_names)}"
            + (f"; loads: {', '.join(data.load_names)}" if data.load_names else ""),
            f"{data.n_modes} flexible coordinates, frequencies {listed} Hz",
            f"Written: {out} ({out.stat().st_size / 1e6:.1f} MB)",
        ]
    )
