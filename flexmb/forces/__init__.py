"""The force library: one kind per file, one import line per kind."""

from flexmb.forces.actuator import Actuator
from flexmb.forces.airload import Airload
from flexmb.forces.bi_stop import BiStop
from flexmb.forces.bushing import Bushing
from flexmb.forces.cam_follower import CamFollower
from flexmb.forces.central_gravity import CentralGravity
from flexmb.forces.contact import Contact
from flexmb.forces.contact_laws import ContactLaw, ElasticFoundation, Hertz
from flexmb.forces.dc_motor import DcMotor
from flexmb.forces.gears import Gears
from flexmb.forces.hydraulic_cylinder import HydraulicCylinder
from flexmb.forces.joint_friction import JointFriction
from flexmb.forces.line_contact import LineContact
from flexmb.forces.line_load import LineLoad
from flexmb.forces.lu_gre import LuGre
from flexmb.forces.maxwell_damper import MaxwellDamper
from flexmb.forces.motor import Motor
from flexmb.forces.muscle import Muscle
from flexmb.forces.oblate_gravity import OblateGravity
from flexmb.forces.one_sided_spring import OneSidedSpring
from flexmb.forces.point_load import PointLoad
from flexmb.forces.pressure import Pressure
from flexmb.forces.rigid_law import Rigid
from flexmb.forces.skin_contact import SkinContact
from flexmb.forces.solar_pressure import SolarPressure
from flexmb.forces.spring_damper import SpringDamper
from flexmb.forces.surface_contact import SurfaceContact
from flexmb.forces.thin_drag import ThinDrag
from flexmb.forces.third_body import ThirdBody
from flexmb.forces.torsion_spring import TorsionSpring
from flexmb.forces.user_force import UserForce
from flexmb.model.kinds import Force
from flexmb.model.registered import registered

KINDS = registered(globals(), Force)
"""All forces by name: read by the model files, the contract tests and the reference pages."""
VALUES = registered(globals(), ContactLaw)
"""The laws of contacts by name, for model files: ``law = { kind = "Hertz", stiffness = 1e9 }``."""

__all__ = ["KINDS", *KINDS, "VALUES", *VALUES]
