"""Files: model files, sensor tables, VTK. Every format has its own file here."""

from flexmb.io.campbell_table import write_campbell
from flexmb.io.column_files import read_columns
from flexmb.io.deck_page import deck_numbers, write_deck_report
from flexmb.io.file_parameters import parse_setting
from flexmb.io.mbdyn_fem import read_mbdyn_fem, write_mbdyn_fem
from flexmb.io.mode_series import write_modes
from flexmb.io.model_file import OpenModelFile, load_model, load_simulation, read_model_text
from flexmb.io.plant_file import plant_path, write_plant
from flexmb.io.pole_tables import write_poles
from flexmb.io.quality_page import report_numbers, write_report
from flexmb.io.response_tables import write_response, write_spectra
from flexmb.io.run_motion import motion_of
from flexmb.io.save_model import model_text, save_model
from flexmb.io.sensor_tables import labels, write_table
from flexmb.io.sid import read_sid, write_sid
from flexmb.io.simulation_settings import Simulation
from flexmb.io.vtk_output import write_vtk

__all__ = [
    "OpenModelFile",
    "Simulation",
    "deck_numbers",
    "labels",
    "load_model",
    "load_simulation",
    "model_text",
    "motion_of",
    "parse_setting",
    "plant_path",
    "read_columns",
    "read_mbdyn_fem",
    "read_model_text",
    "read_sid",
    "report_numbers",
    "save_model",
    "write_campbell",
    "write_deck_report",
    "write_mbdyn_fem",
    "write_modes",
    "write_plant",
    "write_poles",
    "write_report",
    "write_response",
    "write_sid",
    "write_spectra",
    "write_table",
    "write_vtk",
]
