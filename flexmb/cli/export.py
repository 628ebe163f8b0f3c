"""Write the results of a run folder in other formats: ParaView files and the sensor table."""

from __future__ import annotations

import argparse
from pathlib import Path

import flexmb as fmb
from flexmb.cli.model_arguments import add_trust
from flexmb.cli.run_folder import open_run
from flexmb.files import resolved

NAME = "export"
SUMMARY = "write ParaView files or the sensor table of a run folder"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", help="run folder")
    add_trust(parser)
    parser.add_argument(
        "--vtk", action="store_true", help="PVD with one VTU per body and frame: any ParaView (default)"
    )
    parser.add_argument("--vtkhdf", action="store_true", help="one VTKHDF file per body with an XDMF sidecar")
    parser.add_argument("--csv", action="store_true", help="sensors over time")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="every n-th sample only")
    parser.add_argument(
        "--surface", action="store_true", help="the skin of solid bodies only: smaller files, nothing to cut through"
    )
    parser.add_argument("--to", metavar="FOLDER", help="where to write; default: the run folder")


ELSEWHERE = {".xdmf": " 5.12 or newer the .vtkhdf files, in older ones with 'XDMF Reader' (not Xdmf3)"}
"""What to add where not every ParaView opens a file by itself."""


def execute(arguments: argparse.Namespace) -> int:
    solution = open_run(arguments.run, trust=arguments.trust)
    name = resolved(arguments.run).name
    target = Path(arguments.to) if arguments.to else Path(arguments.run)
    target.mkdir(parents=True, exist_ok=True)
    nothing = not (arguments.vtk or arguments.vtkhdf or arguments.csv)
    for ending, asked in ((".pvd", arguments.vtk or nothing), (".vtkhdf", arguments.vtkhdf)):
        if asked:
            file = target / f"{name}{ending}"
            written = fmb.write_vtk(solution, file, every=arguments.every, surface=arguments.surface)
            print(f"Open in ParaView{ELSEWHERE.get(written.suffix, '')}: {written}")
            script = fmb.view.paraview_script(solution, file)
            print(f"  ready-made, with colours, camera and time: paraview --script={script}")
    if arguments.csv:
        print(f"Sensors: {fmb.write_table(solution, target / 'sensors.csv')}")
    return 0
