"""Parameters of Abaqus and CalculiX keywords: used, without effect on a linear structure, or left out by name."""

from __future__ import annotations

from flexmb.fem.deck.abaqus_text import Block
from flexmb.fem.deck.contents import Inventory

__all__ = ["MESH", "tell_parameters"]

MESH = ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE")
"""Keywords of the mesh, which are read before the others."""

USED = {
    "SOLID SECTION": "ELSET MATERIAL ORIENTATION",
    "SHELL SECTION": "ELSET MATERIAL ORIENTATION COMPOSITE OFFSET NODALTHICKNESS",
    "MEMBRANE SECTION": "ELSET MATERIAL ORIENTATION",
    "BEAM SECTION": "ELSET MATERIAL SECTION OFFSET1 OFFSET2",
    "BEAM GENERAL SECTION": "ELSET MATERIAL SECTION DENSITY",
    "MASS": "ELSET",
    "ROTARY INERTIA": "ELSET ORIENTATION",
    "SPRING": "ELSET ORIENTATION NONLINEAR",
    "DASHPOT": "ELSET ORIENTATION NONLINEAR",
    "RIGID BODY": "REFNODE ROTNODE ELSET NSET PINNSET TIENSET",
    "COUPLING": "REFNODE SURFACE CONSTRAINTNAME ORIENTATION",
    "KINEMATIC": "",
    "DISTRIBUTING": "",
    "KINEMATIC COUPLING": "REFNODE",
    "DISTRIBUTING COUPLING": "ELSET",
    "TIE": "NAME ADJUST POSITIONTOLERANCE CYCLICSYMMETRY MULTISTAGE FLUIDPERIODIC FLUIDCYCLIC",
    "EQUATION": "REMOVE",
    "MPC": "",
    "MATERIAL": "NAME",
    "ELASTIC": "TYPE",
    "DENSITY": "",
    "ORIENTATION": "NAME SYSTEM",
    "TRANSFORM": "NSET TYPE",
    "NODAL THICKNESS": "",
    "NODE": "NSET SYSTEM",
    "ELEMENT": "TYPE ELSET",
    "NSET": "NSET ELSET GENERATE INSTANCE",
    "ELSET": "ELSET GENERATE INSTANCE",
    "SURFACE": "NAME TYPE",
    "BOUNDARY": "OP",
}
"""By keyword, spaces left away."""
WITHOUT_EFFECT = {
    "SOLID SECTION": "CONTROLS STACKDIRECTION SYMMETRIC",
    "SHELL SECTION": "CONTROLS POISSON SECTIONINTEGRATION STACKDIRECTION SYMMETRIC TEMPERATURE LAYUP",
    "MEMBRANE SECTION": "CONTROLS POISSON",
    "BEAM SECTION": "TEMPERATURE LUMPED POISSON",
    "BEAM GENERAL SECTION": "ZERO LUMPED POISSON",
    "MASS": "ALPHA COMPOSITE",
    "ROTARY INERTIA": "ALPHA COMPOSITE",
    "SPRING": "DEPENDENCIES RTOL COMPLEXSTIFFNESS",
    "DASHPOT": "DEPENDENCIES RTOL",
    "TIE": "TYPE",
    "MATERIAL": "RTOL SRATETYPE STRAINRATEREGULARIZATION",
    "ELASTIC": "DEPENDENCIES",
    "DENSITY": "DEPENDENCIES",
    "ORIENTATION": "LOCALDIRECTIONS",
    "NSET": "UNSORTED INTERNAL",
    "ELSET": "UNSORTED INTERNAL",
    "SURFACE": "INTERNAL",
    "BOUNDARY": "AMPLITUDE FIXED TYPE",
}
"""Of output, of integration, of tables (by their first line), of sections that shrink as they stretch, of motions of
supports, and defaults."""
DEFAULTS = {
    ("ELASTIC", "MODULI"): "LONG",
    ("ORIENTATION", "DEFINITION"): "COORDINATES",
    ("RIGID BODY", "POSITION"): "INPUT",
    ("DISTRIBUTING", "WEIGHTINGMETHOD"): "UNIFORM",
    ("DISTRIBUTING", "COUPLING"): "CONTINUUM",
    ("TIE", "CONSTRAINTRATIO"): "0",
}
"""Values that ask for what is done anyway, by their beginning."""


def tell_parameters(block: Block, inventory: Inventory) -> None:
    """Note every parameter of a keyword that is read here but is not taken itself."""
    if block.name not in USED:
        return
    taken = {"INPUT", *USED[block.name].split(), *WITHOUT_EFFECT.get(block.name, "").split()}
    for name, value in block.parameters.items():
        usual = DEFAULTS.get((block.name, name))
        if name not in taken and not (usual is not None and value.upper().startswith(usual)):
            shown = f" = {value:.40}" if value else ""
            inventory.left_out[f"*{block.name}: the parameter {name}{shown}"] += 1
