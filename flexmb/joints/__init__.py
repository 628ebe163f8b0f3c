"""The joint library: one kind per file, one import line per kind."""

from flexmb.joints.constant_velocity import ConstantVelocity
from flexmb.joints.constraint import Constraint
from flexmb.joints.coupler import Coupler
from flexmb.joints.cylindrical import Cylindrical
from flexmb.joints.drive import Drive
from flexmb.joints.fixed import Fixed
from flexmb.joints.gear_pair import GearPair
from flexmb.joints.in_line import InLine
from flexmb.joints.planar import Planar
from flexmb.joints.point_on_curve import PointOnCurve
from flexmb.joints.point_on_path import PointOnPath
from flexmb.joints.point_on_plane import PointOnPlane
from flexmb.joints.prismatic import Prismatic
from flexmb.joints.rack_and_pinion import RackAndPinion
from flexmb.joints.revolute import Revolute
from flexmb.joints.rod import Rod
from flexmb.joints.rolling import Rolling
from flexmb.joints.screw import Screw
from flexmb.joints.spherical import Spherical
from flexmb.joints.universal import Universal
from flexmb.model.kinds import Joint
from flexmb.model.registered import registered

KINDS = registered(globals(), Joint)
"""All joints by name: read by the model files, the contract tests and the reference pages."""

__all__ = ["KINDS", *KINDS]
