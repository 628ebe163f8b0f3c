"""Quantities read from the state: the same sensors feed events, tables, plots and tests."""

from flexmb.sensors.axis_cosine import AxisCosine
from flexmb.sensors.constraint_error import ConstraintError
from flexmb.sensors.deflection import Deflection
from flexmb.sensors.distance import Distance
from flexmb.sensors.energy import Energy
from flexmb.sensors.joint_coordinate import JointCoordinate
from flexmb.sensors.loads import ForceOf, Reaction
from flexmb.sensors.marker_motion import Acceleration, AngularVelocity, Orientation, Position, Velocity
from flexmb.sensors.momentum import Momentum
from flexmb.sensors.multiplier import Multiplier
from flexmb.sensors.section import SectionForces, SectionStrains
from flexmb.sensors.stress import Stress
from flexmb.sensors.stress_resultants import StressResultants

__all__ = [
    "KINDS",
    "Acceleration",
    "AngularVelocity",
    "AxisCosine",
    "ConstraintError",
    "Deflection",
    "Distance",
    "Energy",
    "ForceOf",
    "JointCoordinate",
    "Momentum",
    "Multiplier",
    "Orientation",
    "Position",
    "Reaction",
    "SectionForces",
    "SectionStrains",
    "Stress",
    "StressResultants",
    "Velocity",
]

KINDS = {
    kind.__name__: kind
    for kind in (
        Position,
        Velocity,
        AngularVelocity,
        Acceleration,
        Orientation,
        Distance,
        AxisCosine,
        JointCoordinate,
        Reaction,
        Multiplier,
        ForceOf,
        Deflection,
        SectionForces,
        SectionStrains,
        Stress,
        StressResultants,
        Energy,
        Momentum,
        ConstraintError,
    )
}
"""All kinds of sensors by name."""

VALUES = KINDS
"""What may stand in a field: the quantities of a constraint."""
