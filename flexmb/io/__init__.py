"""Files: model files, sensor tables, VTK. Every format has its own file here."""

from flexmb.io.file_parameters import parse_setting
from flexmb.io.mode_series import write_modes
from flexmb.io.model_file import load_model, load_simulation, read_model_text
from flexmb.io.quality_page import report_numbers, write_report
from flexmb.io.save_model import model_text, save_model
from flexmb.io.sensor_tables import labels, write_table
from flexmb.io.simulation_settings import Simulation
from flexmb.io.vtk_output import write_vtk

__all__ = [
    "Simulation",
    "labels",
    "load_model",
    "load_simulation",
    "model_text",
    "parse_setting",
    "read_model_text",
    "report_numbers",
    "save_model",
    "write_modes",
    "write_report",
    "write_table",
    "write_vtk",
]
