"""Finite elements: every way to arrive at an `FEModel`."""

from flexmb.fem.deck import DECK_READERS, DeckChecks, deck_checks, read_deck
from flexmb.fem.fe_model import ElementBlock, FEModel, ReferencePoint
from flexmb.fem.frames.frame import frame
from flexmb.fem.frames.section import Section
from flexmb.fem.joined import joined
from flexmb.fem.links.connectors import with_mass, with_spring, with_supports
from flexmb.fem.links.links import with_averaging_link, with_node, with_rigid_link
from flexmb.fem.matrices.from_matrices import from_matrices
from flexmb.fem.matrices.read_matrices import read_matrices, write_matrices
from flexmb.fem.measured_modes import MeasuredModes, modal_assurance, read_measured_modes
from flexmb.fem.measured_responses import MeasuredResponse, read_measured_responses
from flexmb.fem.meshes.mesh import Mesh, MeshWarning
from flexmb.fem.meshes.read_mesh import read_mesh
from flexmb.fem.shells.shell import shell
from flexmb.fem.solids.elements import HEX8_COMPATIBLE, WEDGE6_COMPATIBLE, SolidElement
from flexmb.fem.solids.solid import solid
from flexmb.fem.solve import Modes, buckling, eigenmodes, fixed_freedoms, static
from flexmb.fem.split import split
from flexmb.fem.surface_file import read_surface
from flexmb.fem.surface_load import pressure_load, traction_load

__all__ = [
    "DECK_READERS",
    "HEX8_COMPATIBLE",
    "WEDGE6_COMPATIBLE",
    "DeckChecks",
    "ElementBlock",
    "FEModel",
    "MeasuredModes",
    "MeasuredResponse",
    "Mesh",
    "MeshWarning",
    "Modes",
    "ReferencePoint",
    "Section",
    "SolidElement",
    "buckling",
    "deck_checks",
    "eigenmodes",
    "fixed_freedoms",
    "frame",
    "from_matrices",
    "joined",
    "modal_assurance",
    "pressure_load",
    "read_deck",
    "read_matrices",
    "read_measured_modes",
    "read_measured_responses",
    "read_mesh",
    "read_surface",
    "shell",
    "solid",
    "split",
    "static",
    "traction_load",
    "with_averaging_link",
    "with_mass",
    "with_node",
    "with_rigid_link",
    "with_spring",
    "with_supports",
    "write_matrices",
]
