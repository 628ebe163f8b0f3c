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
    "SlowRunWarning ValidityWarning",
    "flexmb.model": "MATERIALS Material Model ModalNeutralData Orbit OrthotropicMaterial Pose",
    "flexmb.forces.moving_load": "moving_load",
    "flexmb.model.blocks": "DeadZone Integral Lag Limit Pid RateLimit",
    "flexmb.model.function_block": "Delay Function",
    "flexmb.model.held_blocks": "Quantiser Relay Sampled SampledStateSpace",
    "flexmb.model.input_signal": "input",
    "flexmb.model.linear_blocks": "StateSpace TransferFunction",
    "flexmb.model.measurement": "formula measured",
    "flexmb.model.signal": "expression",
    "flexmb.model.simple_signals": "harmonic ramp step",
    "flexmb.model.table2_signal": "table2",
    "flexmb.model.table_signal": "table",
    "flexmb.mechanisms": "LineNetwork ModifiedLink StandardLink line_network serial_arm",
    "flexmb.events": "Change Event Impact Lock Release Stop Unlock",
    "flexmb.integrate": "ArcLength Augmented Baumgarte LoadSteps NullSpace UdwadiaPhohomsiri accelerations campbell "
    "check disturbed equations first_frequencies impulses inverse_dynamics kinematics linearize mode_motion "
    "resume root_locus simulate spectral_response statics stepper variances",
    "flexmb.tree": "Centroid JointTree Recursive RelativeState",
    "flexmb.profiles": "Arc Cam Disc Involute Line Outline Profile Slot SmoothOutline Spline",
    "flexmb.results": "Solution Status wear",
    "flexmb.trust": "Verification verify",
    "flexmb.study": "sweep",
    "flexmb.io": "Simulation load_model load_simulation model_text read_model_text save_model write_table write_vtk",
}
_KINDS = ("flexmb.bodies", "flexmb.surfaces", "flexmb.joints", "flexmb.forces", "flexmb.sensors", "flexmb.integrate")
"""Rooms whose kinds are public as soon as the room imports them."""
_DOORS = ("fem", "fmi", "io", "parts", "reduction", "study", "view")
_MODULES = {"udwadia": "flexmb.math.udwadia"}
_HOME = {name: room for room, names in _ROOMS.items() for name in names.split()}


def _kinds(room: str) -> set[str]:
    module = import_module(room)
    return {*module.KINDS, *getattr(module, "VALUES", ())}


def __getattr__(name: str) -> Any:
    if name == "__all__":
        return [
            "__version__",
            *sorted({*_HOME, *_DOORS, *_MODULES, *(kind for room in _KINDS for kind in _kinds(room))}),
        ]
    if name in _HOME:
        value = getattr(import_module(_HOME[name]), name)
        globals()[name] = value
        return value
    if name in _DOORS or name in _MODULES:
        return import_module(_MODULES.get(name, f"flexmb.{name}"))
    if name[:1].isupper():
        for room in _KINDS:
            if name in _kinds(room):
                globals()[name] = getattr(import_module(room), name)
                return globals()[name]
    raise AttributeError(f"module 'flexmb' has no attribute '{name}'")


def __dir__() -> list[str]:
    return __getattr__("__all__")
