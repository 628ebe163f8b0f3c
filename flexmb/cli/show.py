"""Show a reduced body: its quality report, its first modes as a picture, its modes for ParaView.

Example: flexmb show conrod.h5 --vtk
Of a deck (.bdf, .dat, .inp): what is in it, what it weighs, what hangs apart, a picture with its interfaces.
Example: flexmb show wing.bdf --units "mm, t, s" --html
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import flexmb as fmb
from flexmb.errors import FlexmbError, ModelError

NAME = "show"
SUMMARY = "print the quality report of a reduced body, draw its modes; or what is in a deck"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("data", help="reduced body (.h5), written by `flexmb reduce`, or a deck (.bdf, .dat, .inp)")
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
