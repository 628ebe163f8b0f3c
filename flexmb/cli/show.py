"""Show a reduced body: its quality report, its first modes as a picture, its modes for ParaView.

Example: flexmb show conrod.h5 --vtk
Of a deck (.bdf, .dat, .inp): what is in it, what it weighs, and what hangs apart.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import flexmb as fmb
from flexmb.errors import FlexmbError

NAME = "show"
SUMMARY = "print the quality report of a reduced body, draw its modes; or what is in a deck"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("data", help="reduced body (.h5), written by `flexmb reduce`, or a deck (.bdf, .dat, .inp)")
    parser.add_argument("--units", metavar="UNITS", help='of a deck: "mm, t, s"')
    parser.add_argument("-o", "--out", metavar="FILE", help="picture of the modes; default: <data>_modes.png")
    parser.add_argument(
        "--modes", type=int, default=6, metavar="N", help="modes in the picture; default: 6; 0: no picture"
    )
    parser.add_argument(
        "--vtk",
        action="store_true",
        help="write all mode shapes and stress modes for ParaView: <data>_modes.pvd",
    )
    parser.add_argument(
        "--html",
        action="store_true",
        help="write the report with the picture as a web page: <data>.html, .json",
    )


def execute(arguments: argparse.Namespace) -> int:
    from flexmb import fem, io

    source = Path(arguments.data)
    if source.suffix.lower() in fem.DECK_READERS:
        fe = fem.read_deck(source, units=arguments.units)
        print()
        for line in fem.deck_checks(fe):
            print(line)
        return 0
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


def _drawn(data: fmb.ModalNeutralData, modes: int, asked: str | None, usual: Path) -> Path | None:
    """Draw the modes; a missing picture is an error only if it was requested."""
    from flexmb import view

    if modes == 0:
        return None
    try:
        picture = view.mode_sheet(data, asked or usual, modes=modes)
    except FlexmbError as error:
        if asked:
            raise
        print(f"No picture. {error}")
        return None
    print(f"Picture: {picture}")
    return picture
