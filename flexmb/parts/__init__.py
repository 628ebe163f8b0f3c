"""Parts of finite elements as descriptions: what a body is made of, reduced when it is asked for and kept by content.

A model file writes a part as the table ``data`` of a body (docs/howto/parts-in-model-files.md); in Python it is an
object: ``flexmb.FloatingBody("beam", data=parts.Part(...))``.
"""

from flexmb.parts.body_cache import BodyCache, body_folder, clear_bodies, kept_bodies
from flexmb.parts.extrusion import Bore, Boss, Extrusion
from flexmb.parts.kept_models import reduced
from flexmb.parts.line import Line
from flexmb.parts.mesh_file import MeshFile, Stretch
from flexmb.parts.nodal_loads import Each, Forces
from flexmb.parts.part import Part
from flexmb.parts.plate import Plate
from flexmb.parts.surface_file import SurfaceFile
from flexmb.parts.ties import Arm, AveragingLink, Mass, RigidLink, Spring
from flexmb.parts.watchers import Count, Watcher, watching
from flexmb.reduction.load_tables import LineTable, PressureTable

__all__ = [
    "LINKS",
    "LOADS",
    "MASSES",
    "PIECES",
    "Arm",
    "AveragingLink",
    "BodyCache",
    "Bore",
    "Boss",
    "Count",
    "Each",
    "Extrusion",
    "Forces",
    "Line",
    "Mass",
    "MeshFile",
    "Part",
    "Plate",
    "RigidLink",
    "Spring",
    "Stretch",
    "SurfaceFile",
    "Watcher",
    "body_folder",
    "clear_bodies",
    "kept_bodies",
    "reduced",
    "watching",
]

PIECES: dict[str, type] = {kind.__name__: kind for kind in (Line, Plate, MeshFile, Extrusion)}
"""What finite elements are made from, by the word of model files."""
LINKS: dict[str, type] = {kind.__name__: kind for kind in (Arm, RigidLink, AveragingLink)}
LOADS: dict[str, type] = {kind.__name__: kind for kind in (Forces, LineTable, PressureTable, SurfaceFile)}
MASSES: dict[str, type] = {kind.__name__: kind for kind in (Mass, Spring)}
