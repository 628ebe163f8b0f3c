"""Quantities read from the state: the same sensors feed events, tables, plots and tests."""

from flexmb.model.kinds import Sensor
from flexmb.model.registered import registered
from flexmb.sensors.axis_cosine import AxisCosine
from flexmb.sensors.constraint_error import ConstraintError
from flexmb.sensors.contact_state import ContactState
from flexmb.sensors.deflection import Deflection
from flexmb.sensors.distance import Distance
from flexmb.sensors.energy import Energy
from flexmb.sensors.flexible_coordinate import ModalCoordinate, StrainGauge
from flexmb.sensors.impulse_of import ImpulseOf
from flexmb.sensors.joint_coordinate import JointCoordinate
from flexmb.sensors.loads import ForceOf, Reaction
from flexmb.sensors.marker_motion import Acceleration, AngularVelocity, Orientation, Position, Velocity
from flexmb.sensors.momentum import Momentum
from flexmb.sensors.multiplier import Multiplier
from flexmb.sensors.orbital_motion import OrbitalPosition, OrbitalVelocity
from flexmb.sensors.section import SectionForces, SectionStrains
from flexmb.sensors.signal_value import SignalValue
from flexmb.sensors.state import State
from flexmb.sensors.stress import Stress
from flexmb.sensors.stress_resultants import StressResultants

KINDS = registered(globals(), Sensor)
"""All kinds of sensors by name: read by the model files, the contract tests and the reference pages."""

VALUES = KINDS
"""What may stand in a field: the quantities of a constraint."""

__all__ = ["KINDS", *KINDS]
