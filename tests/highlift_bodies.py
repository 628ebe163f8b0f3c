"""Elastic bodies of the high-lift example by hand, with `fem` and `reduction`: flaps, tracks, droop nose, hinge arms,
slats.

    shear centre line 0.33 c: beam nodes, one per rib         nose, area centre 0.42 c and trailing edge hang on
       o------o------o------o------o------o   span            rigid arms; track fittings are interfaces

The model files describe the same bodies; what they are made of is looked at here."""

import numpy as np

import flexmb as fmb
from flexmb import fem, reduction

PATH = 1.156  # m, of the carriage of track 2
ROLLERS = 0.30  # m, base of its rollers; assumed
GEARBOX = (0.20, 0.20, 0.40)  # m: input gearbox behind the actuator, spacing of its bushings, cross shaft; assumed
FITTING = 4.0  # kg, each fitting is a rigid body of its own; assumed, part of the flap's mass
RIB = 2.0  # kg, each rib of the droop nose is a rigid body of its own; assumed, part of the nose's mass
NOSE_EA = 1e8  # N; assumed, the flap's scaled by the bending stiffness
SLAT = {
    "EA": 5e7,
    "shear_centre_chord_fraction": 0.40,
    "cg_chord_fraction": 0.45,
    "shear_centre_zeta": 0.0,
}  # N; assumed
SKIN = {"young": 55e9, "poisson": 0.3}  # carries E I and G J of the data set, whatever its moduli are


def flap_model(
    data: dict,
    start: float,
    end: float,
    ribs: dict[str, float],
    loads: list[float],
    name: str,
    fitting: float = FITTING,
):
    """Return the FE model of a flap from span `start` to `end`; named nodes at fittings and at nose points."""
    places = np.unique(np.round([start, *loads, *ribs.values(), end], 9))
    chord = np.interp(places, [start, end], data["chord"])
    shear, centre = data["shear_centre_chord_fraction"], data["cg_chord_fraction"]
    mass = data["mass_per_length"] - len(ribs) * fitting / (end - start)
    area = data["EA"] / SKIN["young"]
    skin = fmb.Material(**SKIN, density=mass / area)
    modulus = SKIN["young"] / (2.0 * (1.0 + SKIN["poisson"]))
    sections = [
        # the section's y-axis points forward
        fem.Section.values(
            area,
            data["EI_flapwise"] / SKIN["young"],
            data["EI_chordwise"] / SKIN["young"],
            data["GJ"] / modulus,
            polar=data["rotary_inertia_per_length"] / skin.density,
            area_center=(-(centre - shear) * c, 0.0),
            mass_center=(-(centre - shear) * c, 0.0),
        )
        for c in chord
    ]
    nodes = np.column_stack([shear * chord, places, np.full(len(places), data["shear_centre_zeta"])])
    sets = {rib: [int(np.argmin(np.abs(places - y)))] for rib, y in ribs.items()}
    fe = fem.frame(nodes, section=sections, material=skin, node_sets=sets, rotary_inertia=False, name=name)
    for k, y in enumerate(places):
        number = 1 + int(np.argmin(np.abs(np.array(loads) - y)))
        is_load = np.isclose(loads[number - 1], y)
        arms = {f"nose_{number}" if is_load else f"nose at {y:g}": 0.0, f"area centre {k}": centre, f"edge {k}": 1.0}
        for arm, fraction in arms.items():
            fe = fem.with_node(fe, (fraction * chord[k], y, 0.0), name=arm)
            fe = fem.with_rigid_link(fe, k, arm)
    return fe


def reduced_flap(data, start, end, ribs, loads, factors, name):
    """Reduce a flap; load shapes: force normal and along the chord and moment at the nose points,
    per q and coefficient.
    """
    fe = flap_model(data, start, end, ribs, loads, name)
    noses = {f"nose_{k}": fe.node_sets[f"nose_{k}"] for k in range(1, len(loads) + 1)}
    strip = (end - start) / len(loads)
    chords = np.interp(loads, [start, end], data["chord"])
    forces = dict(zip((int(n[0]) for n in noses.values()), strip * chords * factors))
    moments = dict(zip(forces, strip * chords**2 * factors))
    shapes = {
        "normal": reduction.NodalForces({n: (0, 0, f) for n, f in forces.items()}),
        "chord": reduction.NodalForces({n: (f, 0, 0) for n, f in forces.items()}),
        "moment": reduction.NodalForces({n: (0, 0, 0, 0, m, 0) for n, m in moments.items()}),
    }
    interfaces = {rib: [int(fe.node_sets[rib][0])] for rib in ribs}
    stations = {name: [int(n[0])] for name, n in noses.items()}
    return reduction.reduce(
        fe,
        interfaces,
        modes=12,
        stations=stations,
        loads=shapes,
        residual_vectors=tuple(shapes),
        geometric_stiffness=True,
    )


def inboard_flap(data: dict) -> fmb.ModalNeutralData:
    """Return the inboard flap, axes of the wing, nose line of the retracted flap at x = z = 0."""
    flap, wing = data["trailing_edge"]["inboard_flap"], data["trailing_edge"]
    ribs = {
        "root": wing["track_1"]["y"],
        "tip": wing["track_2"]["y"],
        "rib": wing["interconnection_strut"]["y_inboard"],
    }
    return reduced_flap(flap, *flap["y_range"], ribs, flap["nose_points_y"], np.ones(7), "inboard_flap")


def outboard_flap(data: dict) -> fmb.ModalNeutralData:
    """Return the outboard flap, in its frame O."""
    wing, flap = data["trailing_edge"], data["trailing_edge"]["outboard_flap"]
    tracks = dict(zip(("root", "mid", "tip"), (track["Y"] for track in wing["outboard_tracks"])))
    ribs = {"rib": wing["interconnection_strut"]["outboard_attachment_Y"], **tracks}
    factors = np.array(data["airloads"]["outboard"]["spanwise_factor"])
    return reduced_flap(flap, 0.0, flap["span"], ribs, flap["nose_points_Y"], factors, "outboard_flap")


def track_model(data: dict, front, actuator, foot, scale: float, size: float, name: str):
    """Return the FE model of a track in its axes t, y, n from the retracted front joint; sets name its places."""
    beam = data["trailing_edge"]["track_beams"]
    material = data["materials"][beam["material"]]
    rail = np.radians(14.0)
    t, n = np.array([np.cos(rail), -np.sin(rail)]), np.array([np.sin(rail), np.cos(rail)])
    arms = {"A": np.array(actuator) - front, "P": np.array(foot) - front}
    arms = {key: np.array([d @ t, 0.0, d @ n]) for key, d in arms.items()}
    low, high = (scale * s for s in beam["s_range"])
    first, second = (scale * s for s in beam["wing_attachments_s"])
    path = scale * np.linspace(-ROLLERS / 2, PATH + ROLLERS / 2, 7)
    along = {"front": first, "rear": second, "actuator": arms["A"][0], "foot": arms["P"][0]}
    along |= {f"carriage {k}": s for k, s in enumerate(path)}
    behind, spacing, cross = GEARBOX
    gearbox = arms["A"][0] + behind
    along |= {"gearbox": gearbox, "gearbox_front": gearbox - spacing / 2, "gearbox_rear": gearbox + spacing / 2}
    places = np.unique(np.round([low, -0.4 * scale, high, *along.values()], 12))
    sets = {key: [int(np.argmin(np.abs(places - s)))] for key, s in along.items()}
    nodes = np.column_stack([places, np.zeros(len(places)), np.full(len(places), scale * beam["axis_offset_n"])])
    section = fem.Section.box(
        size * beam["section"]["width"], size * beam["section"]["height"], beam["section"]["wall"]
    )
    solid = fmb.Material(young=material["E"], poisson=material["nu"], density=material["rho"])
    fe = fem.frame(nodes, section=section, material=solid, node_sets=sets, name=name)
    for key, holder in (("A", "actuator"), ("P", "foot")):
        fe = fem.with_rigid_link(fem.with_node(fe, arms[key], name=key), sets[holder][0], key)
    input_at = (gearbox, cross, scale * beam["axis_offset_n"])
    fe = fem.with_rigid_link(fem.with_node(fe, input_at, name="gearbox_input"), sets["gearbox"][0], "gearbox_input")
    half = size * beam["section"]["width"] / 2.0
    for k, s in enumerate(path):
        for key, y in (
            (f"rail {k} -1", -half),
            (f"rail {k} 1", half),
            (f"centre_{k + 1}", 0.0),
            (f"edge_{k + 1}", half),
        ):
            fe = fem.with_rigid_link(fem.with_node(fe, (s, y, 0.0), name=key), sets[f"carriage {k}"][0], key)
    return fe


def track_beam(*arguments) -> fmb.ModalNeutralData:
    """Reduce a track; knots of its rail hang on the beam under what the rollers reach, "rail" moves like their mean."""
    fe = track_model(*arguments)
    interfaces = {key: [int(fe.node_sets[key][0])] for key in ("front", "rear", "actuator", "foot")}
    stations = {key: [int(fe.node_sets[key][0])] for key in ("A", "P")}
    stations["rail"] = [int(nodes[0]) for key, nodes in fe.node_sets.items() if key.startswith("rail")]
    knots = [f"{name}_{k}" for name in ("centre", "edge") for k in range(1, 8)]
    stations |= {key: [int(fe.node_sets[key][0])] for key in (*knots, "gearbox_front", "gearbox_rear", "gearbox_input")}
    loads = {
        f"carriage {k}": reduction.NodalForces({int(fe.node_sets[f"carriage {k}"][0]): (0, 0, 1)}) for k in (0, 3, 6)
    }
    return reduction.reduce(
        fe, interfaces, modes=6, stations=stations, loads=loads, residual_vectors=tuple(loads), geometric_stiffness=True
    )


def track_arguments(data: dict) -> dict[str, tuple]:
    """Return what describes the tracks, by the name of the file."""
    two, out = data["trailing_edge"]["track_2"], data["trailing_edge"]["outboard_mechanism"]
    size = data["trailing_edge"]["track_beams"]["section_scale_outboard"]
    front, actuator, foot = (
        np.array(point)[[0, 2]]
        for point in (two["front_joint_retracted"], two["drive"]["actuator_axis"], two["pendulum_foot"])
    )
    outer = (np.array(out[key]) for key in ("front_joint_on_flap", "actuator_axis_XZ", "pendulum_foot_XZ"))
    return {
        "track_2": (data, front, actuator, foot, 1.0, 1.0, "track_2"),
        "track_outboard": (data, *outer, out["scale_to_track_2"], size, "track_outboard"),
    }


def droop_nose_model(data: dict):
    """Return the FE model of the droop nose in frame L; named nodes at the hinge arms,
    at the side strut and at nose points.
    """
    nose, length = data["droop_nose"], data["droop_nose"]["span"]
    arms = {f"n{k}": y for k, y in enumerate(nose["hinge_arm_Y"], 1)} | {"side": nose["side_strut_H"][1]}
    loads = length * (np.arange(6) + 0.5) / 6
    places = np.unique(np.round([0.0, *loads, *arms.values(), length], 9))
    aft = nose["chord"] * np.array([1.0, 0.0, -0.15 / 0.95])  # along the chord, from the nose point to the hinge
    offset = nose["cg_chord_fraction"] - nose["shear_centre_chord_fraction"]
    area = NOSE_EA / SKIN["young"]
    skin = fmb.Material(**SKIN, density=(nose["mass"] - len(arms) * RIB) / length / area)
    centre = (-offset * nose["chord"], 0.0)  # the section's y-axis points forward
    section = fem.Section.values(
        area,
        nose["EI_flapwise"] / SKIN["young"],
        nose["EI_chordwise"] / SKIN["young"],
        nose["GJ"] * 2.0 * (1.0 + SKIN["poisson"]) / SKIN["young"],
        polar=area * (0.25 * nose["chord"]) ** 2,
        area_center=centre,
        mass_center=centre,
    )
    tip = np.array([-nose["chord"], 0.0, 0.15])
    nodes = tip + nose["shear_centre_chord_fraction"] * aft + np.outer(places, [0.0, 1.0, 0.0])
    sets = {name: [int(np.argmin(np.abs(places - y)))] for name, y in arms.items()}
    fe = fem.frame(
        nodes, section=section, material=skin, orientation=-aft, node_sets=sets, rotary_inertia=False, name="droop_nose"
    )
    for k, y in enumerate(loads, 1):
        fe = fem.with_node(fe, tip + (0.0, y, 0.0), name=f"nose_{k}")
        fe = fem.with_rigid_link(fe, int(np.argmin(np.abs(places - y))), f"nose_{k}")
    return fe


def droop_nose(data: dict) -> fmb.ModalNeutralData:
    """Return the droop nose in frame L; load shapes: unit force normal and along the chord and unit moment at the nose
    points, of the half of the nose around arm 2 and of that around arm 4; over all, the load has its centroid."""
    fe, nose = droop_nose_model(data), data["droop_nose"]
    ends = {name: [int(fe.node_sets[name][0])] for name in ("n1", "n2", "n3", "n4", "n5", "side")}
    points = [int(fe.node_sets[f"nose_{k}"][0]) for k in range(1, 7)]
    across = fe.nodes[points, 1] - nose["span"] / 2
    shares = 1 / 6 + across * (nose["airloads"]["load_centroid_Y"] - nose["span"] / 2) / np.sum(across**2)
    along = np.array([0.95, 0.0, -0.15]) / np.hypot(0.95, 0.15)
    normal = np.array([0.15, 0.0, 0.95]) / np.hypot(0.95, 0.15)
    shapes = {}
    for arm, strips in ((2, range(3)), (4, range(3, 6))):
        for name, force in (("normal", normal), ("chord", along)):
            shapes[f"{name}_{arm}"] = reduction.NodalForces({points[k]: tuple(shares[k] * force) for k in strips})
        shapes[f"moment_{arm}"] = reduction.NodalForces({points[k]: (0, 0, 0, 0, shares[k], 0) for k in strips})
    return reduction.reduce(fe, ends, modes=8, loads=shapes, residual_vectors=tuple(shapes), geometric_stiffness=True)


def hinge_arm(data: dict) -> fmb.ModalNeutralData:
    """Return a hinge arm of the droop nose: a beam from A to B, at its root the lug E, on it the lug C.

    The drive strut presses on E with 100 kN: it needs a lug on the bearing at A itself. On the open section, which is
    soft in torsion, it would turn sideways. What the beam lacks in mass the lugs have.
    """
    arm, nose = data["droop_nose"]["hinge_arm"], data["droop_nose"]
    material = data["materials"][arm["material"]]
    solid = fmb.Material(
        young=material["E"], poisson=material["E"] / material["G"] / 2.0 - 1.0, density=material["rho"]
    )
    lugs = {name: np.array([nose[name][0], 0.0, nose[name][1]]) for name in "ABCE"}
    length = float(np.linalg.norm(lugs["B"]))
    places = np.array([0.0, lugs["C"] @ lugs["B"] / length, 0.5 * length, length])
    section = fem.Section.values(arm["A_section"], arm["I_bending"], arm["I_lateral"], arm["J"])
    sets = {"A": [0], "foot of C": [1], "B": [3]}
    fe = fem.frame(
        np.outer(places / length, lugs["B"]),
        section=section,
        material=solid,
        orientation=(0, 1, 0),
        node_sets=sets,
        name="hinge_arm",
    )
    for name, holder in (("E", 0), ("C", 1)):
        fe = fem.with_rigid_link(fem.with_node(fe, lugs[name], name=name), holder, name)
    for name in lugs:
        fe = fem.with_mass(fe, int(fe.node_sets[name][0]), (arm["mass"] - solid.density * section.area * length) / 4)
    stations = {name: [int(fe.node_sets[name][0])] for name in "CE"}
    return reduction.reduce(fe, sets, modes=2, stations=stations, geometric_stiffness=True)


def slat(data: dict, number: int) -> fmb.ModalNeutralData:
    """Return slat `number` in its own axes; ball, top and strut_k are the joints at its k-th track,
    four strips of airload.
    """
    slats, rack, k = data["slats"], data["slats"]["rack"], number - 1
    span, chord, mass = (slats[key][k] for key in ("span", "chord", "mass"))
    ribs = {f"track_{n}": fraction * span for n, fraction in enumerate(slats["track_span_fraction"][k], 1)}
    inertia = mass / span * (0.25 * chord) ** 2  # radius of gyration as of the flaps
    values = (
        slats | SLAT | {"chord": [chord, chord], "mass_per_length": mass / span, "rotary_inertia_per_length": inertia}
    )
    loads = [(2 * n - 1) * span / 8 for n in range(1, 5)]
    fe = flap_model(values, 0.0, span, ribs, loads, f"slat_{number}", fitting=0.0)
    path = (rack["roller_path_radius_outer"] + rack["roller_path_radius_inner"]) / 2
    start = np.radians(-5.0)  # of the rack, see slat.toml
    ball = np.array(rack["centre"]) + path * np.array([np.sin(start), np.cos(start)])
    points = {"ball": ball, "top": ball + (0.0, 0.06), "strut": np.array([0.10, 0.0])}
    stations = {f"nose_{n}": [int(fe.node_sets[f"nose_{n}"][0])] for n in range(1, 5)}
    for n, (rib, y) in enumerate(ribs.items(), 1):
        for name, (x, z) in points.items():
            fe = fem.with_node(fe, (x, y, z), name=f"{name}_{n}")
            fe = fem.with_rigid_link(fe, int(fe.node_sets[rib][0]), f"{name}_{n}")
            stations[f"{name}_{n}"] = [int(fe.node_sets[f"{name}_{n}"][0])]
    held = {rib: [int(fe.node_sets[rib][0])] for rib in ribs}
    return reduction.reduce(fe, held, modes=6, stations=stations, geometric_stiffness=True)
