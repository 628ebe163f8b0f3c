"""One part of every registered kind with its required fields, and a model that has what the parts refer to.

A part is made of its required fields, with values by the fields' names; a new required field needs a value here.
"""

from __future__ import annotations

from dataclasses import MISSING, fields

import flexmb as fmb
from flexmb import fem
from flexmb.io import kind_lists

VALUES = {
    "name": "part",
    "markers": ("ground.A", "b.A"),
    "marker": "b.A",
    "joint": "A",
    "joints": ("A", "B"),
    "force": "spring",
    "body": "flexible",
    "mass": 2.0,
    "inertia": ((1.0, 0.1, 0), (0.1, 1.0, 0), (0, 0, 1.0)),
    "stiffness": 1e3,
    "damping": 0.1,
    "load": "flexible.push",
    "through": ("ground.ramp", "ground.side"),
    "sensor": "s",
    "shape": fmb.Sphere(0.2),
    "surfaces": ("floor", ("ball", "box")),
    "skin": "rope.coat",
    "law": fmb.ElasticFoundation(modulus=1e8, thickness=0.01, friction=1 / 3),
}
MORE = {
    "AncfCable": {
        "points": ((0, 0, 0), (1, 0.1, 0), (2, 0, 0)),
        "elements": 4,
        "section": fem.Section.solid_circle(0.01),
        "material": fmb.Material(young=1e9, poisson=0.3, density=1e3),
        "rotation": (0.1, 0.2, 0.3),
        "markers": {"mid": 0.5, "tip": (1.0, (0, 0, 1.0))},
        "stretches": {"wind": (0.1, 0.6)},
        "skins": {"coat": fmb.Skin(spacing=0.1, radius=0.02, between=(0.2, 1.0), faces=True)},
    },
    "AncfBeam": {
        "points": ((0, 0, 0), (1, 0.1, 0), (2, 0, 0)),
        "elements": 4,
        "section": (fem.Section.tube(0.02, 0.002), fem.Section.tube(0.01, 0.001)),
        "lumped_masses": ((0.4, 2.0),),
        "material": fmb.Material(young=1e9, poisson=0.3, density=1e3),
        "orientation": (0, 0, 1),
        "rotary_inertia": (0.1, 0.2),
        "rotation": (0.1, 0.2, 0.3),
        "markers": {"mid": 0.5, "tip": (1.0, (0, 0, 1.0))},
    },
    "AncfPlate": {
        "points": [[(0, 0, 0), (0, 1, 0)], [(2, 0, 0), (2, 1, 0.1)]],
        "elements": (4, 2),
        "thickness": [[0.1, 0.1], [0.05, 0.05]],
        "material": fmb.Material(young=1e9, poisson=0.3, density=1e3),
        "shear": True,
        "shear_factor": 0.8,
        "lumped_masses": [((0.5, 0.25), 2.0)],
        "rotation": (0.1, 0.2, 0.3),
        "markers": {"mid": (0.5, 0.5), "tip": ((1.0, 0.0), (0, 0, 1.0)), "edge": (1.0, "mean")},
        "skins": {"both": fmb.Skin(spacing=0.5)},
    },
    "Event": {
        "sensor": "s",
        "above": 0.1,
        "column": 2,
        "then": (
            fmb.Release("spring"),
            fmb.Lock("A"),
            fmb.Unlock("A"),
            fmb.Change("b", mass=3.0, at=(1, 2, 3)),
            fmb.Change("spring", preload=fmb.ramp(rate=2.0)),
            fmb.Impact(("ground.A", "b.A"), restitution=0.5, along="z"),
            fmb.Stop(),
        ),
        "repeats": True,
    },
    "Ground": {
        "name": "ground",
        "markers": {"A": fmb.Pose((1, 2, 3), (0.1, 0.2, 0.3)), "ramp": (0, 0, 0), "side": (0, 1, 0)},
    },
    "RigidBody": {"at": (1, 2, 3), "rotation": (0.1, 0.2, 0.3), "markers": {"m": (1 / 3, 0, 0)}},
    "PointMass": {"markers": None},
    "FloatingBody": {
        "markers": {"a": fmb.Pose.axes(z=(0, 1, 0))},
        "at": (1, 2, 3),
        "modes": (0, 2, 3),
        "damping": (0.01, 0.02, 0.03),
    },
    "Drive": {"markers": ("", ""), "angle": fmb.ramp(rate=1 / 3, rise=0.2) * 2 + fmb.expression("a*t", a=3)},
    "Rod": {"length": 0.3},
    "RackAndPinion": {"joints": ("A", "slide")},
    "Gears": {"module": 0.002, "teeth": (20, 41), "width": 0.02, "helix": 0.1, "shifts": (1 / 3, 0.0)},
    "GearPair": {"radii": (0.9, 0.05), "inside": True},
    "Bushing": {"stiffness": (1e3, 1e3, 2e3, 10.0, 10.0, 20.0), "damping": (1.0, 1.0, 1.0, 0.1, 0.1, 0.1)},
    "BiStop": {"travel": (-0.028, 0.012), "joint": None, "depth": 1e-3},
    "OneSidedSpring": {"markers": None, "joint": "A", "backlash": 1e-4, "pulls": True},
    "PointOnCurve": {"curve": ((0, 0, 0), (1, 0, 0), (2, 0.5, 0)), "along": "z", "ends": "error"},
    "Contact": {"radius": 0.1, "friction": 0.2},
    "CamFollower": {"profile": fmb.Disc(radius=0.03, center=(0.005, 1 / 3)), "roller": 0.01},
    "DcMotor": {
        "voltage": fmb.ramp(rate=2.0),
        "resistance": 1.0,
        "inductance": 1e-3,
        "constant": 0.1,
        "ratio": -50.0,
    },
    "HydraulicCylinder": {
        "joint": None,
        "valve": fmb.ramp(rate=0.1),
        "areas": (2e-3, 1.2e-3),
        "stroke": 0.4,
        "dead_volume": 1e-4,
        "supply": 2e7,
        "rated_flow": 1e-3,
    },
    "Muscle": {
        "through": ("ground.side", "ground.ramp", "b.A"),
        "radii": (0, 1 / 3, 0),
        "excitation": fmb.ramp(rate=0.1),
        "strength": 900.0,
        "fibre": 0.2,
        "tendon": 1.0,
    },
    "Airload": {"chord": 0.3, "span": 1 / 3, "wind": (fmb.ramp(rate=2.0), 0, 1.0), "wakes": (0.1, 1 / 3)},
    "MaxwellDamper": {"joint": None, "branches": ((2e3, 0.01), (500.0, 1 / 3)), "elongations": (0.0, 0.1)},
    "JointFriction": {"moving": 0.1, "standing": 0.2, "radius": 0.02, "preload": 5.0},
    "UserForce": {"function": "flexmb.studies:law"},
    "SignalValue": {"of": fmb.Lag(fmb.formula("2*rate(x)", over={"x": "s"}, c=0.2), time=0.1)},
    "State": {"of": "spring", "state": "x"},
    "SectionForces": {"body": "rope"},
    "StressResultants": {"body": "sheet", "at": (0.2, 0.7)},
    "SectionStrains": {"body": "rope"},
    "StrainGauge": {"markers": ("flexible.a", "flexible.b"), "offset": (0, 1 / 3, 0)},
    "ContactState": {"force": "touch"},
    "SkinContact": {"surfaces": ("sheet faces", "coat")},
    "LineContact": {
        "stretch": "rope.wind",
        "marker": "ground.origin",
        "radius": 0.1,
        "offset": 0.005,
        "stiffness": 1e6,
        "friction": 0.3,
    },
    "LineLoad": {"stretch": "rope.wind", "force": (0, 0, fmb.ramp(rate=2.0)), "section_axes": True},
    "CentralGravity": {"body": "b", "mu": 4.9e12},
    "OblateGravity": {"body": "b", "j2": 2e-4},
    "SolarPressure": {"area": 3.0, "sun": (fmb.ramp(rate=2.0), 1.0, 0), "mirrored": 0.2, "both_faces": True},
    "ThinDrag": {"area": 3.0, "density": 2e-12, "mirrored": 0.2, "diffuse": 0.5, "leaving": 300.0},
    "ThirdBody": {"body": "b", "mu": 4.9e12, "at": (fmb.ramp(rate=2.0), 3.8e8, 0)},
    "Pressure": {"amount": fmb.ramp(rate=1e3)},
    "Motor": {"target": fmb.ramp(rate=2.0), "stiffness": 5.0, "limits": (-1.0, 3.0)},
    "Actuator": {"effort": fmb.ramp(rate=2.0), "limits": (-1.0, 3.0)},
    "Energy": {"kind": "strain"},
    "AxisCosine": {"axes": ("z", "x")},
    "Constraint": {
        "markers": ("", ""),
        "over": {"s": "s", "v": fmb.Velocity("tip", marker="b.A", axes="ground.A")},
        "equation": "v[0]*s[1] = r*L",
        "parameters": {"r": fmb.ramp(rate=1 / 3), "L": 0.5},
        "forces": {"v[0]": "-c*v[0] + rate(s[1])".replace("c", "2")},
    },
    "JointCoordinate": {"kind": "turn"},
    "Reaction": {"axes": "b.A"},
    "PointLoad": {
        "force": (fmb.table([0, 1, 2], [1, 2, 4], of=fmb.ramp(rate=1.0)), 0, fmb.step(value=2.0)),
        "axes": "b.A",
    },
}


KINDS = [(table, name) for table, kinds in kind_lists.parts().items() for name in kinds]


def stage(data: fmb.ModalNeutralData) -> fmb.Model:
    """Return a model that has what the parts refer to."""
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"A": (0, 0, 0), "ramp": (1, 0, 0), "side": (1, 1, 0)}),
            fmb.RigidBody("b", mass=1, inertia=(1, 1, 1), markers={"A": (0, 0, 0)}),
            fmb.RigidBody("c", mass=1, inertia=(1, 1, 1)),
            fmb.FloatingBody("flexible", data=data),
            fmb.AncfCable("rope", **MORE["AncfCable"]),
            fmb.AncfPlate("sheet", **MORE["AncfPlate"]),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.A", shape=fmb.Plane()),
            fmb.Surface("ball", marker="b.A", shape=fmb.Sphere(0.1), spacing=0.05),
            fmb.Surface("box", marker="c.center", shape=fmb.Cuboid(size=(0.1, 0.2, 0.3)), spacing=0.1),
            fmb.SkinSurface("coat", skin="rope.coat"),
            fmb.SkinSurface("sheet faces", skin="sheet.both"),
        ],
        joints=[
            fmb.Revolute("A", markers=("ground.A", "b.A")),
            fmb.Revolute("B", markers=("b.A", "c.center")),
            fmb.Prismatic("slide", markers=("ground.A", "c.center")),
        ],
        forces=[
            fmb.SpringDamper("spring", markers=("ground.A", "b.A"), stiffness=1.0),
            fmb.SurfaceContact(
                "touch", surfaces=("floor", "ball"), law=fmb.ElasticFoundation(modulus=1e6, thickness=0.1)
            ),
        ],
        sensors=[fmb.Position("s", marker="b.A")],
    )


def required(kind, given=()) -> dict:
    """Return values of the required fields of a kind, those in `given` left out: by their names, numbers 0.25."""
    found = {}
    for f in fields(kind):
        if f.init and f.default is MISSING and f.default_factory is MISSING and f.name not in given:
            known = VALUES if f.type not in ("float", float) else {f.name: 0.25, **VALUES}
            assert f.name in known, f"what is a value of {kind.__name__}.{f.name}? Add it to VALUES"
            found[f.name] = known[f.name]
    return found


def model_with(table: str, name: str, ground: fmb.Model, data: fmb.ModalNeutralData):
    """Return the stage with one part of a kind, and the part."""
    kind, more = kind_lists.parts()[table][name], MORE.get(name, {})
    values = {}
    for f in fields(kind):
        required = f.default is MISSING and f.default_factory is MISSING
        if f.name in more:
            values[f.name] = more[f.name]
        elif f.name == "data":
            values[f.name] = data
        elif f.name == "markers" and table == "body":
            continue
        elif f.init and (required or f.name in ("markers", "marker")):
            known = VALUES if f.type != "float" else {f.name: 0.25, **VALUES}
            assert f.name in known, f"what is a value of {name}.{f.name}? Add it to VALUES or MORE"
            values[f.name] = known[f.name]
    own = {
        "name": values.get("name", "ground"),
        **{k: v for k, v in values.items() if k != "name" and v is not None},
    }
    part = kind(**own)
    kept = [b for b in ground.bodies if b.name != part.name]
    if table == "body":
        return fmb.Model(bodies=[*kept, part]), part
    return ground.with_parts(**{kind_lists.FAMILIES[table]: [part]}), part
