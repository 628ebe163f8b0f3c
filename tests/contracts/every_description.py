"""One sound description of every public kind that is no part of a model by itself, and what a user does with it.

Signals and blocks, shapes, profiles, laws, settings, materials, pieces of parts, loads, bases. The parts of models are
in `every_kind`.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import flexmb as fmb
from flexmb import fem, io, parts, reduction, system

__all__ = ["DESCRIPTIONS", "Description", "changed", "model_of"]

MESHES = Path(__file__).parents[2] / "meshes"
X = fmb.JointCoordinate("x", joint="rail")


class Description(NamedTuple):
    """What makes it, with which fields, and what is done with it."""

    make: Callable[..., Any]
    fields: dict[str, Any]
    use: Callable[[Any], Any]


def _model(**more: Any) -> fmb.Model:
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"A": (0, 0, 0)}),
            fmb.RigidBody("b", mass=1.0, inertia=(1.0, 1.0, 1.0), markers={"A": (0, 0, 0)}),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.A", "b.A"))],
        **more,
    )


def _pushed(signal) -> fmb.Model:
    return _model(forces=[fmb.Actuator("push", joint="rail", effort=signal)])


def _signal(signal) -> None:
    model = _pushed(signal)
    system.compile(model)
    try:
        text = io.model_text(model)
    except fmb.ModelError:  # functions stand in no file
        return
    io.read_model_text(text)


def _position(signal) -> None:
    repr(signal)
    system.compile(_model(sensors=[fmb.SignalValue("s", of=signal)]))


def _touching(shape, law=None) -> fmb.Model:
    law = law or fmb.ElasticFoundation(modulus=1e6, thickness=0.1)
    surfaces = [
        fmb.Surface("floor", marker="ground.A", shape=fmb.Plane()),
        fmb.Surface("other", marker="b.A", shape=shape, spacing=None if isinstance(shape, fmb.Plane) else 0.1),
    ]
    if isinstance(shape, fmb.Plane):
        surfaces[0] = fmb.Surface("floor", marker="ground.A", shape=fmb.Sphere(0.1), spacing=0.1)
    return _model(surfaces=surfaces, forces=[fmb.SurfaceContact("touch", surfaces=("floor", "other"), law=law)])


def _contact(shape) -> None:
    _compiled(_touching(shape))


def _compiled(model: fmb.Model) -> None:
    system.compile(model)
    io.model_text(model)


def _law(law) -> None:
    _compiled(_touching(fmb.Sphere(0.1), law))


def _followed(profile) -> fmb.Model:
    follower = fmb.CamFollower("cam", markers=("ground.A", "b.A"), profile=profile, roller=0.001, stiffness=1e6)
    return _model(forces=[follower])


def _profile(profile) -> None:
    _compiled(_followed(profile))


def _walked(piece) -> fmb.Model:
    return _followed(fmb.Outline(start=(0.0, 0.0), pieces=[fmb.Line(to=(0.1, 0.0)), piece], ends=True))


def _piece(piece) -> None:
    _compiled(_walked(piece))


def _drawn(shape) -> None:
    body = fmb.RigidBody("c", mass=1.0, inertia=(1.0, 1.0, 1.0), markers={"A": (0, 0, 0)}, shape=shape)
    model = fmb.Model(bodies=[fmb.Ground(), body])
    io.model_text(model)


def _action(action) -> None:
    model = _model(
        forces=[fmb.SpringDamper("spring", markers=("ground.A", "b.A"), stiffness=1.0, length=1.0)],
        sensors=[fmb.Position("s", marker="b.A")],
        events=[fmb.Event("e", sensor="s", column=0, above=1.0, then=action)],
    )
    system.compile(model)
    io.model_text(model)


def _integrator(integrator) -> None:
    fmb.simulate(_model(), t_end=1e-3, samples=2, integrator=integrator)


def _settings(settings) -> None:
    fmb.simulate(_model(), **settings.keywords())


def _formulation(formulation) -> None:
    fmb.accelerations(_model(), formulation=formulation)


def _placed(pose) -> None:
    model = _model().with_parts(
        bodies=[fmb.PointMass("m", mass=1.0), fmb.RigidBody("c", mass=1.0, inertia=(1, 1, 1), markers={"A": pose})]
    )
    system.compile(model)
    io.model_text(model)


def _path(settings) -> None:
    push = fmb.PointLoad("f", marker="b.A", force=(0, 0, fmb.ramp(rate=1.0)))
    hold = fmb.SpringDamper("k", markers=("ground.A", "b.A"), stiffness=1.0, length=0.0)
    fmb.statics(_model(forces=[hold, push]), t=0.1, path=settings)


@cache
def _bar() -> fem.FEModel:
    return fem.frame(
        points=np.linspace((0, 0, 0), (1.0, 0, 0), 5),
        section=fem.Section.rectangle(0.02, 0.03),
        material=fmb.MATERIALS["steel"],
    )


def _reduced(**more: Any) -> None:
    reduction.reduce(_bar(), **{"interfaces": {"a": [0], "b": [4]}, "modes": 2, "compare": 0, **more})


def _line(**more: Any) -> parts.Line:
    return parts.Line(
        **{
            "points": [(0, 0, 0), (1.0, 0, 0)],
            "section": fem.Section.rectangle(0.02, 0.03),
            "material": "steel",
            "elements": 4,
            "nodes": {"mid": 0.5},
            **more,
        }
    )


def _part(**more: Any) -> None:
    part = parts.Part(
        **{"pieces": [_line()], "interfaces": {"a": "start", "b": "end"}, "modes": 2, "compare": 0, **more}
    )
    part.recipe()
    part.reduced()


def _finite(piece) -> None:
    piece.finite_elements()


STATE_SPACE = {"of": X, "A": [[-1.0]], "B": [[1.0]], "C": [[1.0]], "D": [[0.0]], "start": (0.1,), "name": "s"}
RAMP = fmb.ramp(rate=1.0)
PROFILES = {
    "Outline": Description(
        fmb.Outline,
        {"start": (0, 0), "pieces": (fmb.Line(to=(0.1, 0)), fmb.Line(to=(0, 0.1))), "ends": False},
        _profile,
    ),
    "Disc": Description(fmb.Disc, {"radius": 0.03, "center": (0.005, 0.0), "hollow": False}, _profile),
    "Slot": Description(fmb.Slot, {"through": ((0, 0), (0.1, 0.02), (0.2, 0)), "width": 0.02}, _profile),
    "Cam": Description(
        fmb.Cam,
        {
            "base_radius": 0.03,
            "motion": ((3.0, 0.01, "cycloidal"), (2 * np.pi, 0.0, "harmonic")),
            "roller": 0.005,
            "offset": 0.001,
            "start": 0.0,
            "count": 60,
        },
        _profile,
    ),
    "Cam, pivot": Description(
        fmb.Cam,
        {
            "base_radius": 0.03,
            "motion": ((3.0, 0.1, "polynomial"), (2 * np.pi, 0.0, "harmonic")),
            "roller": 0.005,
            "pivot": (0.08, 0.0),
            "arm": 0.08,
            "count": 60,
        },
        _profile,
    ),
    "Line": Description(fmb.Line, {"to": (0.1, 0.1)}, _piece),
    "Arc": Description(fmb.Arc, {"center": (0.1, 0.05), "sweep": 3.0}, _piece),
    "Spline": Description(
        fmb.Spline, {"through": ((0.1, 0.02), (0.08, 0.05), (0.0, 0.1)), "tangents": ((1, 0), (-1, 0))}, _piece
    ),
    "Involute": Description(fmb.Involute, {"base_radius": 0.05, "radius": 0.12, "side": 1, "center": (0, 0)}, _piece),
}
DESCRIPTIONS: dict[str, Description] = {
    **PROFILES,
    "ramp": Description(fmb.ramp, {"rate": 1.0, "rise": 0.1, "start": 0.2}, _signal),
    "step": Description(fmb.step, {"value": 1.0, "initial": 0.0, "at": 0.1, "rise": 0.1}, _signal),
    "harmonic": Description(
        fmb.harmonic, {"amplitude": 1.0, "frequency": 1.0, "phase": 0.1, "offset": 0.1, "start": 0.0}, _signal
    ),
    "table": Description(
        fmb.table, {"x": [0.0, 1.0, 2.0], "y": [0.0, 1.0, 0.0], "of": RAMP, "kind": "linear", "periodic": True}, _signal
    ),
    "table2": Description(
        fmb.table2,
        {
            "x": [0.0, 1.0],
            "y": [0.0, 1.0, 2.0],
            "z": [[0.0, 1.0, 0.0], [1.0, 2.0, 0.0]],
            "of": (X, RAMP),
            "kind": "linear",
        },
        _signal,
    ),
    "expression": Description(lambda text, **more: fmb.expression(text, **more), {"text": "2*t*a", "a": 1.0}, _signal),
    "formula": Description(
        lambda text, **more: fmb.formula(text, **more), {"text": "-k*x", "over": {"x": X}, "k": 1.0}, _signal
    ),
    "measured": Description(fmb.measured, {"of": X, "column": 0, "rate": False}, _signal),
    "input": Description(fmb.input, {"name": "torque", "value": 1.0}, _signal),
    "Limit": Description(fmb.Limit, {"of": X, "limits": (-1.0, 1.0)}, _signal),
    "DeadZone": Description(fmb.DeadZone, {"of": X, "limits": (-1.0, 1.0)}, _signal),
    "Lag": Description(fmb.Lag, {"of": X, "time": 0.1, "start": 0.0, "size": 1.0, "name": "lag"}, _signal),
    "Integral": Description(
        fmb.Integral,
        {"of": X, "gain": 1.0, "start": 0.0, "limits": (-1.0, 1.0), "tracking": 0.1, "size": 1.0, "name": "i"},
        _signal,
    ),
    "Pid": Description(
        fmb.Pid,
        {
            "of": X,
            "kp": 1.0,
            "ki": 2.0,
            "kd": 0.1,
            "rate": None,
            "filter": 0.01,
            "limits": (-1.0, 1.0),
            "tracking": 0.1,
            "start": 0.0,
            "size": 1.0,
            "name": "pid",
        },
        _signal,
    ),
    "RateLimit": Description(
        fmb.RateLimit, {"of": X, "limits": (-1.0, 1.0), "time": 0.1, "start": 0.0, "size": 1.0, "name": "r"}, _signal
    ),
    "Function": Description(
        fmb.Function, {"of": X, "function": lambda t, x: x[0], "jacobian": lambda t, x: [1.0], "name": "f"}, _signal
    ),
    "Delay": Description(fmb.Delay, {"of": X, "time": 0.1, "order": 2, "name": "d"}, _signal),
    "Relay": Description(
        fmb.Relay, {"of": X, "limits": (-1.0, 1.0), "values": (0.0, 1.0), "on": False, "name": "r"}, _signal
    ),
    "Quantiser": Description(fmb.Quantiser, {"of": X, "step": 0.1, "hysteresis": 0.1, "name": "q"}, _signal),
    "Sampled": Description(fmb.Sampled, {"of": X, "period": 0.1, "offset": 0.0, "start": 0.0, "name": "s"}, _signal),
    "SampledStateSpace": Description(
        fmb.SampledStateSpace, {**STATE_SPACE, "period": 0.1, "offset": 0.0, "row": 0}, _signal
    ),
    "StateSpace": Description(fmb.StateSpace, {**STATE_SPACE, "row": 0, "sizes_of_states": (1.0,)}, _signal),
    "TransferFunction": Description(
        fmb.TransferFunction,
        {"of": X, "numerator": (1.0,), "denominator": (0.1, 1.0), "start": (0.0,), "name": "t"},
        _signal,
    ),
    "SignalValue": Description(lambda of: of, {"of": RAMP}, _position),
    "Plane": Description(fmb.Plane, {}, _contact),
    "Sphere": Description(fmb.Sphere, {"radius": 0.1}, _contact),
    "Cylinder": Description(fmb.Cylinder, {"radius": 0.1, "length": 0.3}, _contact),
    "Capsule": Description(fmb.Capsule, {"radius": 0.1, "length": 0.3}, _contact),
    "Cuboid": Description(fmb.Cuboid, {"size": (0.1, 0.2, 0.3)}, _contact),
    "ExtrudedProfile": Description(fmb.ExtrudedProfile, {"profile": fmb.Disc(radius=0.1), "length": 0.2}, _contact),
    "TriangleMesh": Description(
        fmb.TriangleMesh,
        {
            "vertices": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
            "triangles": ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)),
            "file": None,
            "scale": 1.0,
        },
        _contact,
    ),
    "Hull": Description(fmb.Hull, {"points": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))}, _contact),
    "ElasticFoundation": Description(
        fmb.ElasticFoundation,
        {"modulus": 1e6, "thickness": 0.1, "damping": 0.1, "friction": 0.2, "transition": 0.01},
        _law,
    ),
    "Hertz": Description(fmb.Hertz, {"stiffness": 1e6, "damping": 0.1, "friction": 0.2, "transition": 0.01}, _law),
    "Rigid": Description(fmb.Rigid, {"restitution": 0.5, "friction": 0.2, "drilling": 0.01, "rolling": 0.01}, _law),
    "Ball": Description(fmb.Ball, {"radius": 0.1, "at": (0, 0, 0), "on": "A"}, _drawn),
    "Box": Description(fmb.Box, {"size": (0.1, 0.2, 0.3), "at": (0, 0, 0), "on": "A"}, _drawn),
    "Tube": Description(fmb.Tube, {"start": (0, 0, 0), "end": (1, 0, 0), "radius": 0.1, "on": "A"}, _drawn),
    "Extrusion": Description(
        fmb.Extrusion, {"outline": ((0, 0), (1, 0), (0, 1)), "depth": (-0.1, 0.1), "axis": "z", "on": "A"}, _drawn
    ),
    "Change": Description(fmb.Change, {"part": "spring", "stiffness": 2.0}, _action),
    "Impact": Description(fmb.Impact, {"markers": ("ground.A", "b.A"), "restitution": 0.5, "along": "z"}, _action),
    "Lock": Description(fmb.Lock, {"joint": "rail"}, _action),
    "Unlock": Description(fmb.Unlock, {"joint": "rail"}, _action),
    "Release": Description(fmb.Release, {"part": "spring"}, _action),
    "GeneralizedAlpha": Description(
        fmb.GeneralizedAlpha, {"rho_inf": 0.8, "step": 1e-3, "rtol": 1e-5, "atol": 1e-6, "largest": 1.0}, _integrator
    ),
    "Explicit": Description(
        fmb.Explicit, {"rtol": 1e-5, "atol": 1e-6, "drift": 1e-6, "largest": 1.0, "most_steps": 1000}, _integrator
    ),
    "IDA": Description(
        fmb.IDA, {"rtol": 1e-5, "atol": 1e-6, "max_order": 3, "largest": 1.0, "most_steps": 1000}, _integrator
    ),
    "Implicit": Description(fmb.Implicit, {"rtol": 1e-5, "atol": 1e-6, "step": 1e-3, "largest": 1.0}, _integrator),
    "MoreauJean": Description(fmb.MoreauJean, {"step": 1e-3, "tolerance": 1e-8, "sweeps": 100}, _integrator),
    "Simulation": Description(
        fmb.Simulation, {"t_end": 1e-3, "samples": 2, "integrator": None, "start": None}, _settings
    ),
    "Baumgarte": Description(fmb.Baumgarte, {"formulation": fmb.Augmented(), "alpha": 1.0, "beta": 1.0}, _formulation),
    "Recursive": Description(fmb.Recursive, {"cut": ("rail",)}, _formulation),
    "Pose": Description(fmb.Pose, {"at": (0, 0, 1), "rotation": (0.1, 0, 0)}, _placed),
    "Pose.axes": Description(fmb.Pose.axes, {"at": (0, 0, 1), "x": (1, 0, 0), "z": (0, 0, 1)}, _placed),
    "ArcLength": Description(fmb.ArcLength, {"start": 0.0, "step": 0.1, "longest": 0.5, "points": 3}, _path),
    "LoadSteps": Description(fmb.LoadSteps, {"steps": 3, "start": 0.0}, _path),
    "Orbit": Description(
        fmb.Orbit, {"place": (7e6, 0, 0), "velocity": (0, 7500.0, 0), "mu": 4e14}, lambda o: fmb.Model(origin=o)
    ),
    "Material": Description(
        fmb.Material,
        {"young": 2e11, "poisson": 0.3, "density": 7850.0, "name": "steel"},
        lambda m: _line(material=m).finite_elements(),
    ),
    "OrthotropicMaterial": Description(
        fmb.OrthotropicMaterial,
        {
            "young": (1e10, 2e10, 3e10),
            "poisson": (0.1, 0.2, 0.1),
            "shear": (1e9, 1e9, 1e9),
            "density": 1e3,
            "rotation": (0, 0, 0.1),
            "name": "wood",
        },
        lambda m: fem.solid(fem.read_mesh(MESHES / "bracket_hex8.msh"), m),
    ),
    "Model": Description(
        fmb.Model,
        {
            "bodies": (fmb.Ground(), fmb.PointMass("m", mass=1.0)),
            "joints": (),
            "forces": (),
            "sensors": (),
            "events": (),
            "surfaces": (),
            "gravity": (0, 0, -9.81),
            "name": "m",
            "parameters": {"a": 1.0},
        },
        lambda m: (system.compile(m), io.model_text(m)),
    ),
    "Section.rectangle": Description(
        fem.Section.rectangle, {"width": 0.02, "height": 0.03}, lambda s: _line(section=s).finite_elements()
    ),
    "Section.tube": Description(
        fem.Section.tube, {"diameter": 0.02, "wall": 0.003}, lambda s: _line(section=s).finite_elements()
    ),
    "parts.Line": Description(
        _line,
        {
            "points": ((0, 0, 0), (1.0, 0, 0)),
            "section": fem.Section.rectangle(0.02, 0.03),
            "material": "steel",
            "elements": 4,
            "nodes": {"mid": 0.5},
            "orientation": (0, 0, 1),
            "shear": True,
            "rotary_inertia": True,
            "lumped": False,
            "name": "line",
            "size": None,
        },
        _finite,
    ),
    "parts.Plate": Description(
        parts.Plate,
        {
            "corners": ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)),
            "thickness": 0.01,
            "material": "steel",
            "size": 0.5,
            "nodes": {"mid": (0.5, 0.5)},
            "lumped": False,
            "stress_side": 0.0,
            "name": "plate",
        },
        _finite,
    ),
    "parts.MeshFile": Description(
        parts.MeshFile,
        {
            "file": str(MESHES / "bracket_hex8.msh"),
            "material": "steel",
            "thickness": None,
            "groups": (),
            "scale": 1.0,
            "lumped": False,
            "name": "mesh",
            "stretch": parts.Stretch(along=(1, 0, 0), between=(0.0, 0.01), by=0.01),
        },
        _finite,
    ),
    "parts.Stretch": Description(
        parts.Stretch,
        {"along": (1, 0, 0), "between": (0.0, 0.01), "by": 0.01},
        lambda s: parts.MeshFile(file=MESHES / "bracket_hex8.msh", material="steel", stretch=s).finite_elements(),
    ),
    "parts.Arm": Description(
        parts.Arm,
        {"of": "mid", "offset": (0, 0, 0.1), "name": "arm", "extends": False},
        lambda link: _part(links=[link]),
    ),
    "parts.RigidLink": Description(
        parts.RigidLink, {"nodes": "mid", "reference": (0.5, 0, 0.1), "name": "r"}, lambda link: _part(links=[link])
    ),
    "parts.AveragingLink": Description(
        parts.AveragingLink,
        {"nodes": [0, 2, 4], "reference": (0.5, 0, 0), "weights": (1.0, 2.0, 1.0), "name": "r"},
        lambda link: _part(pieces=[_line(points=((0, 0, 0), (1.0, 0, 0), (1.0, 1.0, 0)))], links=[link]),
    ),
    "parts.Mass": Description(
        parts.Mass,
        {"at": "mid", "mass": 1.0, "inertia": (1e-3, 1e-3, 1e-3), "offset": (0, 0, 0.1)},
        lambda mass: _part(masses=[mass]),
    ),
    "parts.Spring": Description(
        parts.Spring, {"at": "start", "to": "end", "stiffness": (1e3,) * 6}, lambda spring: _part(masses=[spring])
    ),
    "parts.Each": Description(parts.Each, {"of": "mid"}, lambda each: _part(stations={"s": each})),
    "parts.Forces": Description(
        parts.Forces,
        {"on": "mid", "force": (0, 0, 1.0), "moment": (0, 0, 1.0), "turns_with": None},
        lambda load: _part(loads={"f": load}),
    ),
    "parts.Part": Description(
        lambda **fields: fields,
        {
            "name": "part",
            "pieces": (_line(),),
            "deck": None,
            "units": None,
            "lumped": None,
            "stress_side": None,
            "links": (),
            "masses": (),
            "interfaces": {"a": "start", "b": "end"},
            "modes": 2,
            "basis": None,
            "stations": {"s": "mid"},
            "loads": {"f": parts.Forces(on="mid", force=(0, 0, 1))},
            "residual_vectors": ("f",),
            "geometric_stiffness": False,
            "stress": True,
            "frame": "buckens",
            "damping": 0.01,
            "preload": {},
            "compare": 0,
            "error_up_to": None,
            "parameters": {},
            "model": "",
        },
        lambda fields: _part(**fields),
    ),
    "Krylov": Description(
        reduction.Krylov,
        {"frequencies": (0.0, 10.0), "order": 2, "two_sided": False},
        lambda basis: _reduced(basis=basis, modes="usual"),
    ),
    "CharacteristicModes": Description(
        reduction.CharacteristicModes, {"interface_modes": 2}, lambda basis: _reduced(basis=basis)
    ),
    "Balanced": Description(
        reduction.Balanced, {"candidates": 6, "damping": 0.01}, lambda basis: _reduced(basis=basis)
    ),
    "Pod": Description(
        reduction.Pod,
        {"snapshots": np.arange(30 * 3.0).reshape(30, 3) ** 2, "energy": 0.99, "statics": True},
        lambda basis: _reduced(basis=basis),
    ),
    "UpTo": Description(reduction.UpTo, {"frequency": 100.0, "accuracy": 0.01}, lambda up: _reduced(modes=up)),
    "Rayleigh": Description(
        reduction.Rayleigh, {"mass": 0.1, "stiffness": 1e-4}, lambda damping: _reduced(damping=damping)
    ),
    "Bands": Description(
        reduction.Bands, {"bands": ((10.0, 0.01), (100.0, 0.02))}, lambda damping: _reduced(damping=damping)
    ),
    "coupling Rigid": Description(
        reduction.Rigid, {"where": [0], "at": (0, 0, 0)}, lambda c: _reduced(interfaces={"a": c, "b": [4]})
    ),
    "coupling Averaging": Description(
        reduction.Averaging,
        {"where": [0, 1], "at": (0, 0, 0), "weights": (1.0, 2.0)},
        lambda c: _reduced(interfaces={"a": c, "b": [4]}),
    ),
    "coupling Nodes": Description(reduction.Nodes, {"where": [0]}, lambda c: _reduced(interfaces={"a": c, "b": [4]})),
    "Track": Description(
        reduction.Track,
        {"where": [1, 2, 3], "direction": (0, 0, 1.0), "rest": 1e-3},
        lambda load: _reduced(loads={"t": load}),
    ),
    "LineLoad": Description(
        fmb.LineLoad,
        {"name": "l", "stretch": "rope.wind", "force": (0, 0, 1.0), "moment": (0, 0, 0), "section_axes": False},
        lambda load: None,
    ),
    "reduction.LineLoad": Description(
        reduction.LineLoad,
        {"where": [0, 1, 2], "direction": (0, 0, 1.0), "turns_with": None},
        lambda load: _reduced(loads={"t": load}),
    ),
    "NodalForces": Description(
        reduction.NodalForces, {"table": {2: (0, 0, 1.0)}, "turns_with": None}, lambda load: _reduced(loads={"t": load})
    ),
    "LineTable": Description(
        reduction.LineTable,
        {
            "points": ((0, 0, 0), (1, 0, 0)),
            "force": (0, 0, (1.0, 2.0)),
            "moment": (0, 0, 0),
            "on": None,
            "reach": 0.5,
            "turns_with": None,
        },
        lambda load: _reduced(loads={"t": load}),
    ),
    "PressureTable": Description(
        reduction.PressureTable,
        {
            "corners": ((0, -0.1, 0), (0, 0.1, 0), (1, 0.1, 0), (1, -0.1, 0)),
            "span": (0, 1.0),
            "chord": (0, 1.0),
            "pressure": ((1.0, 2.0), (2.0, 1.0)),
            "on": None,
            "reach": 0.5,
            "turns_with": None,
        },
        lambda load: _reduced(loads={"t": load}),
    ),
    "SurfacePressure": Description(
        reduction.SurfacePressure,
        {
            "points": ((0, 0, 0), (1, 0, 0), (1, 0.1, 0)),
            "pressure": (1.0, 2.0, 1.0),
            "triangles": ((0, 1, 2),),
            "areas": None,
            "reference": 0.0,
            "factor": 1.0,
            "on": None,
            "reach": 0.5,
            "turns_with": None,
        },
        lambda load: _reduced(loads={"t": load}),
    ),
}


def changed(description: Description, field: str, value: Any) -> dict[str, Any]:
    """Return the fields with one replaced."""
    return {**copy.copy(description.fields), field: value}


MODELS = {
    _signal: _pushed,
    _contact: _touching,
    _law: lambda law: _touching(fmb.Sphere(0.1), law),
    _profile: _followed,
    _piece: _walked,
}


def model_of(name: str) -> fmb.Model | None:
    """Return a model with a description, None for those that stand in no model."""
    description = DESCRIPTIONS[name]
    made = MODELS.get(description.use)
    return None if made is None else made(description.make(**description.fields))
