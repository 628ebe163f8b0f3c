"""Keywords of Abaqus and CalculiX decks before the first step: read, left out, not needed, or not known at all."""

from __future__ import annotations

from flexmb.errors import did_you_mean
from flexmb.fem.deck.contents import Inventory

__all__ = ["taken", "told"]

READ = frozenset(
    (
        *("BEAM GENERAL SECTION", "BEAM SECTION", "BOUNDARY", "COUPLING", "DASHPOT", "DENSITY", "DISTRIBUTING"),
        *("DISTRIBUTING COUPLING", "ELASTIC", "EQUATION", "KINEMATIC", "KINEMATIC COUPLING", "MASS", "MATERIAL"),
        *("MEMBRANE SECTION", "MPC", "NODAL THICKNESS", "ORIENTATION", "RIGID BODY", "ROTARY INERTIA"),
        *("CENTROID", "SHEAR CENTER", "SHELL SECTION", "SOLID SECTION", "SPRING", "TIE", "TRANSFORM"),
        "TRANSVERSE SHEAR STIFFNESS",
    )
)
"""Keywords that the reader takes, besides keywords of the mesh, of parts and of steps."""

LEFT_OUT = frozenset(
    (
        "SHELL TO SOLID COUPLING",
        "EMBEDDED ELEMENT",
        "FASTENER",
        "CONNECTOR SECTION",
        "NONSTRUCTURAL MASS",
        "PRE-TENSION SECTION",
        "CYCLIC SYMMETRY MODEL",
        "SUBMODEL",
        "GAP",
        "JOINT",
        "USER ELEMENT",
        "COHESIVE SECTION",
        "GASKET SECTION",
        "SURFACE SECTION",
        "REBAR LAYER",
        "FLUID SECTION",
        "SHELL GENERAL SECTION",
        "TRANSVERSE SHEAR",
        "MATRIX INPUT",
        "NORMAL",
        "BEAM SECTION OFFSET",
        "CONTACT",
        "CONTACT PAIR",
        "DAMPING",
        "IMPERFECTION",
    )
)
"""Keywords that change the structure and have no counterpart here: a message names them."""
REASONS = {
    "CONTACT": ": what touches is not joined",
    "CONTACT PAIR": ": what touches is not joined",
    "DAMPING": " of a material: give the body its damping",
}

NOT_NEEDED = frozenset(
    (
        *("HEADING", "PREPRINT", "RESTART", "AMPLITUDE", "PHYSICAL CONSTANTS", "PARAMETER", "FILTER", "TIME POINTS"),
        *("VALUES AT INFINITY", "INITIAL CONDITIONS", "PREDEFINED FIELD", "FIELD", "TEMPERATURE", "DISTRIBUTION"),
        *("DISTRIBUTION TABLE", "ELEMENT OUTPUT", "NODE OUTPUT", "OUTPUT", "NODE FILE", "EL FILE", "NODE PRINT"),
        *("EL PRINT", "CONTACT FILE", "CONTACT PRINT", "HOURGLASS STIFFNESS", "SECTION CONTROLS"),
        "SECTION POINTS",
        *("CONTACT INCLUSIONS", "CONTACT EXCLUSIONS", "CONTACT PROPERTY ASSIGNMENT"),
        *("CONTACT INITIALIZATION DATA", "CONTACT INITIALIZATION ASSIGNMENT", "CONTACT CONTROLS", "CONTACT DAMPING"),
        *("CONTACT FORMULATION", "SURFACE PROPERTY ASSIGNMENT", "CLEARANCE", "SURFACE INTERACTION"),
        *("SURFACE BEHAVIOR", "FRICTION", "GAP CONDUCTANCE", "GAP HEAT GENERATION", "COHESIVE BEHAVIOR"),
        *("EXPANSION", "CONDUCTIVITY", "SPECIFIC HEAT", "LATENT HEAT", "INELASTIC HEAT FRACTION", "PLASTIC"),
        *("HYPERELASTIC", "HYPERFOAM", "DEPVAR", "USER MATERIAL", "USER OUTPUT VARIABLES", "CREEP"),
        *("CYCLIC HARDENING", "RATE DEPENDENT", "VISCOELASTIC", "DEFORMATION PLASTICITY", "POTENTIAL"),
        *("DAMAGE INITIATION", "DAMAGE EVOLUTION", "DAMAGE STABILIZATION", "FAIL STRESS", "FAIL STRAIN", "TRS"),
        *("CONCRETE DAMAGED PLASTICITY", "CONCRETE COMPRESSION HARDENING", "CONCRETE TENSION STIFFENING"),
        *("CAST IRON PLASTICITY", "DRUCKER PRAGER", "DRUCKER PRAGER HARDENING", "MOHR COULOMB", "CRUSHABLE FOAM"),
        *("MOHR COULOMB HARDENING", "CRUSHABLE FOAM HARDENING", "ELECTRICAL CONDUCTIVITY", "PERMEABILITY"),
        *("FLUID CONSTANTS", "SPECIFIC GAS CONSTANT", "EMISSIVITY", "CFLUX", "DFLUX", "FILM", "RADIATE"),
        *("INTEGRATED OUTPUT SECTION", "NO COMPRESSION", "NO TENSION", "ANNEAL TEMPERATURE"),
    )
)
"""Keywords of what a linear structure has no part in: results, contact, heat, and materials beyond the elastic."""


def taken(name: str) -> bool:
    """Whether the data lines of a keyword are read."""
    return name not in LEFT_OUT and name not in NOT_NEEDED


def told(name: str, inventory: Inventory) -> None:
    """Note a keyword that is not read: "not needed", or "left out" with a suggestion where nobody knows it."""
    if name in READ:
        return
    if name in NOT_NEEDED:
        inventory.unused[f"*{name}"] += 1
        return
    if name in LEFT_OUT:
        inventory.left_out[f"*{name}{REASONS.get(name, '')}"] += 1
        return
    near = did_you_mean(name, sorted(READ | LEFT_OUT | NOT_NEEDED))
    inventory.left_out[f"*{name}, a keyword that is not known{': ' + near if near else ''}"] += 1
