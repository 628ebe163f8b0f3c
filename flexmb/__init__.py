"""flexmb: flexible multibody dynamics with finite element bodies.

Mesh in, reduced body, mechanism, motion and loads, ParaView out. SI units and radians everywhere.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

# Where each public name lives; it is imported when it is first asked for, so that `import flexmb` stays fast.
_ROOMS = {
    "flexmb.errors": "CompileError DataFileError FlexmbError IntegrationError MeshError ModelError ReductionError "
    "ValidityWarning",
    "flexmb.model": "MATERIALS Material Model ModalNeutralData OrthotropicMaterial Pose",
    "flexmb.model.signal": "expression harmonic ramp step",
    "flexmb.model.table_signal": "table",
    "flexmb.bodies": "AncfBeam AncfCable AncfPlate Box Extrusion FloatingBody Ground PointMass RigidBody Tube",
    "flexmb.joints": "ConstantVelocity Constraint Coupler Cylindrical Drive Fixed GearPair InLine Planar PointOnCurve "
    "PointOnPlane Prismatic RackAndPinion Revolute Rod Rolling Screw Spherical Universal",
    "flexmb.forces": "Actuator BiStop Bushing Contact JointFriction LineContact LineLoad Motor OneSidedSpring "
    "PointLoad Pressure SpringDamper TorsionSpring UserForce",
    "flexmb.sensors": "Acceleration AngularVelocity AxisCosine ConstraintError Deflection Distance Energy ForceOf "
    "JointCoordinate Momentum Multiplier Orientation Position Reaction SectionForces SectionStrains Stress "
    "StressResultants Velocity",
    "flexmb.mechanisms": "LineNetwork ModifiedLink StandardLink line_network serial_arm",
    "flexmb.events": "Change Event Impact Lock Release Stop Unlock",
    "flexmb.integrate": "ArcLength Augmented Baumgarte Explicit GeneralizedAlpha IDA Implicit LoadSteps NullSpace "
    "UdwadiaPhohomsiri accelerations campbell check equations first_frequencies inverse_dynamics kinematics "
    "linearize resume simulate statics",
    "flexmb.tree": "JointTree Recursive RelativeState",
    "flexmb.results": "Solution Status",
    "flexmb.trust": "Verification verify",
    "flexmb.study": "sweep",
    "flexmb.io": "Simulation load_model load_simulation model_text read_model_text save_model write_table write_vtk",
}
_DOORS = ("fem", "io", "parts", "reduction", "study", "view")
_MODULES = {"udwadia": "flexmb.math.udwadia"}
_HOME = {name: room for room, names in _ROOMS.items() for name in names.split()}

__all__ = ["__version__", *sorted({*_HOME, *_DOORS, *_MODULES})]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(import_module(_HOME[name]), name)
        globals()[name] = value
        return value
    if name in _DOORS or name in _MODULES:
        return import_module(_MODULES.get(name, f"flexmb.{name}"))
    raise AttributeError(f"module 'flexmb' has no attribute '{name}'")


def __dir__() -> list[str]:
    return __all__
