"""Pictures, animations and plots of a solution, mode shapes of a body."""

from flexmb.view.bode import bode
from flexmb.view.campbell_diagram import campbell_diagram
from flexmb.view.diagrams import Diagram, draw_diagrams, of_one_unit
from flexmb.view.graphics import require_graphics
from flexmb.view.interactive import KEYS, window
from flexmb.view.loci import root_loci
from flexmb.view.mode_sheet import mode_sheet
from flexmb.view.model_picture import model_picture
from flexmb.view.paraview import paraview_script
from flexmb.view.pictures import overlay, render
from flexmb.view.plots import plot
from flexmb.view.report import report
from flexmb.view.spectra import spectra

__all__ = [
    "KEYS",
    "Diagram",
    "bode",
    "campbell_diagram",
    "draw_diagrams",
    "mode_sheet",
    "model_picture",
    "of_one_unit",
    "overlay",
    "paraview_script",
    "plot",
    "render",
    "report",
    "require_graphics",
    "root_loci",
    "spectra",
    "window",
]
