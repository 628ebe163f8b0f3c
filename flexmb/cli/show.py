"""Show a reduced body: its quality report, its first modes as a picture, its modes for ParaView.

Example: flexmb show conrod.h5 --vtk
Of a deck (.bdf, .dat, .inp): what is in it, what it weighs, what hangs apart, a picture with its interfaces.
Example: flexmb show wing.bdf --units "mm, t, s" --html
Of a mesh (.msh, .vtu, .med, ...): its size, its cells, and the groups that can become interfaces.
Example: flexmb show bracket.msh
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import flexmb as fmb
from flexmb.cli.mesh_lines import mesh_lines
from flexmb.errors import FlexmbError, ModelError

NAME = "show"
SUMMARY = "print the quality report of a reduced body, draw its modes; or what is in a deck or a mesh"


MESHES = (".msh", ".vtu", ".vtk", ".med", ".unv", ".uff")
"""Files that hold a mesh and no properties: those of `fem.read_mesh` that are no decks."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "data", help="reduced body (.h5), written by `flexmb reduce`, a deck (.bdf, .dat, .inp), or a mesh (.msh, ...)"
    )
    parser.add_argument("--units", metavar="UNITS", help='of a deck: "mm, t, s"')
    parser.add_argument("-o", "--out", metavar="FILE", help="picture; default: <data>_modes.png, <deck>_model.png")
    parser.add_argument(
        "--modes",
        type=int,
        default=6,
        metavar="N",
        help="modes in the picture; default: 6; 0: no picture, of a deck too",
    )
    parser.add_argument(
        "--vtk",
        action="store_true",
        help="write all mode shapes and stress modes for ParaView: <data>_modes.pvd",
    )
    parser.add_argument(
        "--html",
        action="store_true",
        help="write the report with the picture as a web page: <data>.html, .json, or <deck>_model.html, .json",
    )


def execute(arguments: argparse.Namespace) -> int:
    from flexmb import fem, io

    source = Path(arguments.data)
    if source.suffix.lower() in fem.DECK_READERS:
        return _show_deck(arguments, source)
    if source.suffix.lower() in MESHES:
        return _show_mesh(arguments, source)
    if source.suffix.lower() == ".toml" and source.is_file():
        raise ModelError(
            f"Model file '{source}'",
            found="it describes a model",
            expected="a reduced body (.h5), or a deck (.bdf, .dat, .inp)",
            remedy=f"For a model: flexmb check {source}, flexmb run {source}; to show a body, name its data file",
        )
    if source.is_dir():
        raise ModelError(
            f"Folder '{source}'",
            found="it is no file",
            expected="a reduced body (.h5), or a deck (.bdf, .dat, .inp)",
            remedy=f"For a run folder: flexmb render {source}, flexmb report {source}; a body: name its file",
        )
    data = fmb.ModalNeutralData.load(source)
    print(data.report())
    print()
    picture = _drawn(data, arguments.modes, arguments.out, source.with_name(f"{source.stem}_modes.png"))
    if arguments.vtk:
        print(f"Open in ParaView: {io.write_modes(data, source.with_name(f'{source.stem}_modes.pvd'))}")
    if arguments.html:
        page, numbers = io.write_report(data, source, picture=picture)
        print(f"Report: {page}, {numbers}")
    return 0


def _show_mesh(arguments: argparse.Namespace, source: Path) -> int:
    """Print the size, the cells and the groups of a mesh: the names that `flexmb reduce` asks for."""
    from flexmb import fem

    asked = [name for name in ("vtk", "html", "units", "out") if getattr(arguments, name)]
    if asked:
        raise ModelError(
            "flexmb show",
            found=f"--{asked[0]} for a mesh",
            expected=f"flexmb show {source}, which prints its groups",
            remedy="Reduce the mesh first: flexmb reduce",
        )
    print("\n".join(mesh_lines(fem.read_mesh(source))))
    return 0


def _show_deck(arguments: argparse.Namespace, source: Path) -> int:
    """Print the inventory of a deck and what was found in it, and draw it."""
    from flexmb import fem, io, view

    if arguments.vtk:
        raise ModelError(
            "flexmb show",
            found="--vtk for a deck",
            expected="--vtk for a reduced body (.h5)",
            remedy="Reduce the deck first: flexmb reduce",
        )
    checks = fem.deck_checks(fem.read_deck(source, units=arguments.units))
    print()
    for line in checks.sentences():
        print(line)
    usual, picture = Path(f"{source.stem}_model.png"), None
    if arguments.modes:
        picture = _picture(lambda path: view.model_picture(checks.fe, path, checks=checks), arguments.out, usual)
    if arguments.html:
        page, numbers = io.write_deck_report(checks, usual.with_suffix(".html"), picture=picture)
        print(f"Report: {page}, {numbers}")
    return 0


def _drawn(data: fmb.ModalNeutralData, modes: int, asked: str | None, usual: Path) -> Path | None:
    """Draw the modes."""
    from flexmb import view

    return _picture(lambda path: view.mode_sheet(data, path, modes=modes), asked, usual) if modes else None


def _picture(draw: Callable[[str | Path], Path], asked: str | None, usual: Path) -> Path | None:
    """Draw; a missing picture is an error only if it was requested."""
    try:
        picture = draw(asked or usual)
    except FlexmbError as error:
        if asked:
            raise
        print(f"No picture. {error}")
        return None
    print(f"Picture: {picture}")
    return picture
