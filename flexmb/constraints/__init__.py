"""The primitive equations that joints forbid with, and the primitive freedoms that they permit."""

from flexmb.constraints.angle import Angle
from flexmb.constraints.coincident import Coincident
from flexmb.constraints.coordinate import Coordinate
from flexmb.constraints.coordinate_kernels import joint_coordinate
from flexmb.constraints.coupled import Coupled
from flexmb.constraints.distance import Distance
from flexmb.constraints.formula import Formula
from flexmb.constraints.freedoms import Ball, Bend, Helix, RollAbout, Slide, Turn, TurnOfSecond
from flexmb.constraints.in_plane import InPlane
from flexmb.constraints.measured import Combination, Measured
from flexmb.constraints.meshing import Meshing
from flexmb.constraints.no_twist import NoTwist
from flexmb.constraints.on_curve import OnCurve, OnTrace
from flexmb.constraints.on_path import OnPath, OnStrip
from flexmb.constraints.perpendicular import Perpendicular
from flexmb.constraints.rolling_contact import NoSlip, Touching
from flexmb.model.primitives import Equation

__all__ = [
    "EQUATIONS",
    "Angle",
    "Ball",
    "Bend",
    "Coincident",
    "Combination",
    "Coordinate",
    "Coupled",
    "Distance",
    "Formula",
    "Helix",
    "InPlane",
    "Measured",
    "Meshing",
    "NoSlip",
    "NoTwist",
    "OnCurve",
    "OnPath",
    "OnStrip",
    "OnTrace",
    "Perpendicular",
    "RollAbout",
    "Slide",
    "Touching",
    "Turn",
    "TurnOfSecond",
    "joint_coordinate",
]

EQUATIONS: tuple[type[Equation], ...] = (
    Coincident,
    InPlane,
    Perpendicular,
    Distance,
    NoTwist,
    Angle,
    Coupled,
    OnCurve,
    OnPath,
    Touching,
    NoSlip,
    Meshing,
    Formula,
)
"""All primitive equations, in the order in which tables are evaluated."""
