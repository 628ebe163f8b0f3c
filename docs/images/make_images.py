"""Draw the diagrams of the documentation from computed results: ``python docs/images/make_images.py [name ...]``.

Needs the source tree: reference solutions come from tests/verification.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot as plt

FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER.parents[1] / "tests"))


def rod_modes(path: Path) -> None:
    """Error of a slider-crank and a four-bar against the full FE model of the rod, over the number of modes."""
    from verification.full_model_cases import errors, full, reduced

    counts = (0, 2, 4, 8, 16, 32, 42)
    figure, axes = plt.subplots(1, 2, figsize=(8, 3.4), sharey=True, layout="constrained")
    for axis, case in zip(axes, ("slider-crank", "four-bar")):
        expected = full(case)
        table = np.array([errors(reduced(case, modes), expected) for modes in counts])
        for row, label, mark in zip(table.T, ("deflection", "force at A", "force at B", "stress"), "osd^"):
            axis.semilogy(counts, row, f"{mark}-", label=label, markersize=4)
        axis.set(title=case, xlabel="fixed-interface modes")
        axis.grid(True, alpha=0.3)
    axes[0].set(ylabel="error relative to the largest value")
    axes[1].legend()
    figure.savefig(path, dpi=120)


def bases(path: Path) -> None:
    """Error of the response between interfaces over the number of shapes: all bases, and pyMOR's where it is there."""
    from reduction.four_bodies import BODIES, body, by_pymor, snapshots, true_error

    from flexmb import reduction

    figure, axes = plt.subplots(1, 4, figsize=(14, 4.1), sharey=True, layout="constrained")
    for axis, name in zip(axes, BODIES):
        fe, interfaces, band, _, _ = body(name)
        moved = snapshots(fe, interfaces, band)
        half, three = (0.0, 0.6 * band), (0.0, 0.35 * band, 0.8 * band)
        cases = {
            "Craig-Bampton": [(reduction.CraigBampton(), n) for n in (0, 2, 4, 8, 16, 24, 36)],
            "Rubin": [(reduction.Rubin(), n) for n in (0, 2, 4, 8, 16, 24, 36)],
            "Krylov": [(reduction.Krylov(f), "usual") for f in ((0.0,), half, three)],
            "POD": [(reduction.Pod(moved), n) for n in (6, 12, 18, 24, 36)],
            "characteristic": [(reduction.CharacteristicModes(k), k) for k in (4, 6, 8, 10)],
            "balanced": [(reduction.Balanced(100), n) for n in (6, 12, 18, 24, 36, 48)],
        }
        for (label, sizes), mark in zip(cases.items(), "osD^vP"):
            made = [
                reduction.reduce(fe, interfaces, n, basis=basis, error_up_to=band, compare=0, stress=False)
                for basis, n in sizes
            ]
            axis.semilogy([d.n_modes for d in made], [true_error(name, d) for d in made], f"{mark}-", label=label, ms=4)
        found = by_pymor(name, (6, 12, 18, 24, 36, 48), made[0].quality["transfer"]["frequencies"])
        axis.semilogy(*zip(*found), "k+:", label="pyMOR, balanced")
        axis.set(title=f"{name}, up to {band:g} Hz", xlabel="shapes", ylim=(1e-8, 20.0))
        axis.grid(True, alpha=0.3)
    axes[0].set(ylabel="error / largest response")
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, ncols=7, loc="outside lower center")
    figure.savefig(path, dpi=120)


def which_body(path: Path) -> None:
    """A beam spun up fast as one floating body, as several, as ANCF cable, and exactly."""
    from verification.fast_spin_up import LENGTH, TIMES, ancf, exact, floating, lag

    beams = {"1 floating body": floating(1), "3 bodies": floating(3), "6 bodies": floating(6), "ANCF, 12": ancf(12)}
    figure, (over_time, over_lag) = plt.subplots(1, 2, figsize=(8.4, 3.4), layout="constrained")
    peaks, errors = [], {name: [] for name in beams}
    for multiple in (0.125, 0.25, 0.5, 1.0, 1.5, 2.0):
        expected = exact(multiple)
        peaks.append(np.abs(expected).max())
        for name, beam in beams.items():
            found = lag(beam, multiple)
            errors[name].append(np.abs(found - expected).max() / peaks[-1])
            if multiple == 2.0 and name != "6 bodies":
                over_time.plot(TIMES, found / LENGTH, label=name)
    over_time.plot(TIMES, expected / LENGTH, "k:", label="exact")
    over_time.set(xlabel="time (s)", ylabel="lag of the tip / length", title="twice the first frequency")
    for name, values in errors.items():
        over_lag.loglog(np.array(peaks) / LENGTH, values, "o-", markersize=4, label=name)
    over_lag.set_xticks((0.02, 0.05, 0.1, 0.2, 0.3), ("2 %", "5 %", "10 %", "20 %", "30 %"))
    over_lag.minorticks_off()
    over_lag.axvline(0.1, color="0.6", linewidth=0.8)
    over_lag.set(xlabel="largest lag / length", ylabel="error / largest lag", title="error over the deflection")
    for axis in (over_time, over_lag):
        axis.grid(True, alpha=0.3)
        axis.legend(fontsize=8)
    figure.savefig(path, dpi=120)


def soft_crank(path: Path) -> None:
    """The rod of a slider-crank as one floating body, several, and in absolute nodal coordinates, stiff to soft."""
    import warnings

    from verification.soft_crank import ROD, TIMES, ancf, bow, floating

    import flexmb as fmb

    warnings.simplefilter("ignore", fmb.ValidityWarning)
    rods = {
        "1 floating body": floating(1),
        "3 bodies": floating(3),
        "6 bodies": floating(6),
        "ANCF beam, 12": ancf(fmb.AncfBeam, 12),
        "ANCF cable, 12": ancf(fmb.AncfCable, 12),
    }
    softness, shown = (1.0, 2.0, 3.0, 5.0, 8.0, 10.0, 12.0, 15.0, 20.0), 15.0
    figure, (over_time, over_bow) = plt.subplots(1, 2, figsize=(8.4, 3.4), layout="constrained")
    peaks, errors = [], {name: [] for name in rods}
    for soft in softness:
        reference = bow(ancf(fmb.AncfCable, 40), soft)
        peaks.append(np.abs(reference).max() / ROD)
        for name, rod in rods.items():
            found = bow(rod, soft)
            errors[name].append(np.abs(found - reference).max() / np.abs(reference).max())
            if soft == shown and "ANCF" not in name:
                over_time.plot(1e3 * TIMES, found / ROD, linewidth=1.1, label=name)
        if soft == shown:
            over_time.plot(1e3 * TIMES, reference / ROD, "k--", linewidth=1.2, label="ANCF cable, 40")
    for name, values in errors.items():
        over_bow.loglog(peaks, values, ".-", label=name)
    over_time.set(
        xlabel="time, ms",
        ylabel="deflection of the rod / length",
        title="rod 15 times as soft as steel",
        ylim=(-0.4, 0.4),
    )
    over_bow.axvline(0.1, color="0.6", linewidth=0.8)
    over_bow.set(
        xlabel="largest deflection / length", ylabel="error / largest deflection", title="error over the deflection"
    )
    for axis in (over_time, over_bow):
        axis.grid(True, alpha=0.3)
        axis.legend(fontsize=7)
    figure.savefig(path, dpi=120)


def snapping_strip(path: Path) -> None:
    """The load on an arched strip over the height of its crown, and its shapes on the way."""
    import runpy

    strip = runpy.run_path(str(FOLDER.parents[1] / "examples" / "snapping_strip.py"))
    equilibria, motion = strip["path"](), strip["snap"]()
    push, height = strip["PUSH"] * equilibria.factor, 1e3 * equilibria["crown"][:, 2]
    figure, (over_height, shapes) = plt.subplots(1, 2, figsize=(8.4, 3.4), layout="constrained")
    over_height.plot(height, push, label="equilibria (arc length)")
    over_height.plot(
        1e3 * motion["crown"][:, 2],
        strip["RATE"] * motion.t,
        "--",
        linewidth=0.9,
        color="C2",
        label=f"motion, {strip['RATE']} N/s",
    )
    for value, label in ((1.555, "shallow arch theory"), (-0.787, None)):
        over_height.axhline(value, color="0.5", linewidth=0.8, linestyle=":", label=label)
    body = equilibria.model.body("strip")
    at = [point.sample for point in equilibria.limit_points]
    middle = at[0] + int(np.argmin(np.abs(height[at[0] : at[1]])))
    for color, k in zip(("C0", "C1", "C3", "C4"), (0, at[0], middle, at[1])):
        line = 1e3 * body.line(equilibria.phases[0].q[k], np.linspace(0.0, 1.0, 81))[5]
        shapes.plot(line[:, 0], line[:, 2], color=color, label=f"P = {push[k]:.2f} N")
        over_height.plot(height[k], push[k], "o", color=color)
    over_height.set(xlabel="height of the crown, mm", ylabel="push, N", ylim=(-1.2, 2.6))
    shapes.set(xlabel="x, mm", ylabel="z, mm (enlarged)", title="shapes")
    for axis in (over_height, shapes):
        axis.grid(True, alpha=0.3)
        axis.legend(fontsize=8)
    figure.savefig(path, dpi=120)


def spacecraft(path: Path) -> None:
    """The parts of the spacecraft in the axes of its bus, and how they move in them."""
    import runpy

    from scipy.spatial.transform import Rotation

    craft = runpy.run_path(str(FOLDER.parents[1] / "examples" / "spacecraft.py"))
    motion, _ = craft["run"](0.15, samples=401)
    axes = {n: Rotation.from_quat(motion[f"axes of {n}"], scalar_first=True) for n in craft["BODIES"]}
    own = {n: axes["bus"].inv().apply(motion[n] - motion["bus"]) for n in axes}

    def seen(marker, k):
        body, point = marker.split(".")
        return own[body][k] + (axes["bus"].inv() * axes[body])[k].apply(craft["POINTS"][body][point])

    figure, (parts, over) = plt.subplots(1, 2, figsize=(8.4, 3.6), layout="constrained")
    k = int(np.argmin(own["module"][:, 1]))
    outline = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (-1, -1, 0)], float)
    for name, half, color in (
        ("bus", (0.5, 0.5, 0), "C0"),
        ("module", (0.3, 0.35, 0), "C1"),
        ("panel", (0.2, 0.7, 0), "C2"),
    ):
        for when, style in ((0, ":"), (k, "-")):
            turned = (axes["bus"].inv() * axes[name])[when].apply(outline * half) + own[name][when]
            parts.plot(turned[:, 0], turned[:, 1], style, color=color, linewidth=1.6 if when else 0.9)
        parts.text(*own[name][0, :2], name, ha="center", va="center", color=color)
    for ends, _ in craft["SPRINGS"]:
        parts.plot(*np.array([seen(end, k)[:2] for end in ends]).T, color="0.5", linewidth=0.8)
    parts.plot(*np.array([seen(end, k)[:2] for end in ("bus.rod", "module.rod")]).T, "ko-", markersize=3)
    parts.set(
        xlabel="x of the bus, m",
        ylabel="y of the bus, m",
        aspect="equal",
        title=f"start (dotted) and after {motion.t[k]:.0f} s",
    )
    for name, color in (("module", "C1"), ("panel", "C2")):
        for axis, style in ((0, "-"), (1, "--"), (2, ":")):
            moved = 1e3 * (own[name][:, axis] - own[name][0, axis])
            over.plot(motion.t, moved, style, color=color, linewidth=1.0, label=f"{name}, {'xyz'[axis]}")
    over.set(
        xlabel="time, s", ylabel="displacement in the axes of the bus, mm", title="the parts swing on their springs"
    )
    over.grid(True, alpha=0.3)
    over.legend(fontsize=7, ncols=2, loc="lower left")
    over.set_ylim(bottom=-750)  # the legend hides no line
    figure.savefig(path, dpi=120)


def towing_chain(path: Path) -> None:
    """Shapes of the towed chain, and the force on its end."""
    import runpy

    chain = runpy.run_path(str(FOLDER.parents[1] / "examples" / "towing_chain.py"))
    motion = chain["run"](samples=33)
    figure, (shapes, force) = plt.subplots(
        1, 2, figsize=(8.4, 3.4), layout="constrained", gridspec_kw={"width_ratios": [2, 1]}
    )
    places = chain["shapes"](motion)
    for k in range(0, 33, 4):
        shapes.plot(*places[k].T, "o-", color=plt.cm.viridis(k / 36), markersize=3, label=f"{motion.t[k]:.1f} s")
    shapes.set(xlabel="x, m", ylabel="y, m", aspect="equal", title="shapes")
    for name, style in (("pull", "-"), ("lift", "--")):
        force.plot(motion.t[1:], motion[name][1:], style, label=name)
    force.set(xlabel="time, s", ylabel="force on the towed end, N", title="multipliers")
    for axis in (shapes, force):
        axis.grid(True, alpha=0.3)
        axis.legend(fontsize=7)
    figure.savefig(path, dpi=120)


def swept_sections(path: Path) -> None:
    """Beams of several sections and a rope, as they are drawn: bent by loads at their ends."""
    import flexmb as fmb
    from flexmb import fem, view

    loads = {"i": 2e5, "box": 2e5, "tube": 1.5e5, "strip": 8e3}
    sections = {
        "i": fem.Section.i(0.1, 0.15, 0.01, 0.01),
        "box": fem.Section.box(0.1, 0.15, 0.01),
        "tube": (fem.Section.tube(0.15, 0.02), fem.Section.tube(0.06, 0.01)),
        "strip": fem.Section.rectangle(0.15, 0.03),
    }
    steel = fmb.MATERIALS["steel"]
    ends = [(0.0, 0.4 * k, 0.0) for k in range(len(loads) + 1)]
    bodies = [
        fmb.AncfBeam(name, points=(end, (2.0, *end[1:])), elements=6, section=section, material=steel)
        for (name, section), end in zip(sections.items(), ends)
    ]
    x = np.linspace(0.0, 2.0, 9)
    arc = np.stack([x, 0.0 * x + ends[-1][1], -0.25 * x * (2.0 - x)], axis=1)
    rope = fmb.AncfCable(
        "rope", points=arc, elements=10, section=fem.Section.solid_circle(0.05), material=steel, straight=True
    )
    ground = fmb.Ground(markers={str(k): end for k, end in enumerate([*ends, (2.0, ends[-1][1], 0.0)])})
    joints = [
        fmb.Fixed(f"clamp {body.name}", markers=(f"ground.{k}", f"{body.name}.start")) for k, body in enumerate(bodies)
    ]
    joints += [
        fmb.Spherical(f"rope {end}", markers=(f"ground.{k}", f"rope.{end}")) for k, end in ((4, "start"), (5, "end"))
    ]
    forces = [fmb.PointLoad(name, marker=f"{name}.end", force=(0, 0, -load)) for name, load in loads.items()]
    view.render(
        fmb.statics(fmb.Model(bodies=[ground, *bodies, rope], joints=joints, forces=forces)),
        path,
        size=(1200, 560),
        camera=(1.0, -0.9, 0.8),
    )


def belt_drive(path: Path) -> None:
    """The belt of the example coloured by its tension, and the tension of one place of it over time."""
    import runpy

    from flexmb.results import recover

    example = runpy.run_path(str(FOLDER.parents[1] / "examples" / "belt_drive.py"))
    solution = example["run"](120)
    belt, q = solution.model.body("belt"), solution.series().coordinates("belt")[0][-1:]
    places = (np.arange(belt.elements) + 0.5) / belt.elements
    at, force = belt.line(q[0], places)[0], recover.line_forces(belt, q, places)[0, :, 0]
    figure, (shape, over_time) = plt.subplots(1, 2, figsize=(8.4, 3.0), layout="constrained", width_ratios=(1.2, 1.0))
    for side in (0.5, -0.5):
        shape.add_patch(plt.Circle((side * example["DISTANCE"], 0.0), example["RADIUS"], color="0.85"))
    points = shape.scatter(at[:, 0], at[:, 1], c=force, s=14, cmap="viridis")
    figure.colorbar(points, ax=shape, label="tension, N", orientation="horizontal", shrink=0.7)
    shape.text(0.25, 0.0, "driver", ha="center", va="center")
    shape.text(-0.25, 0.0, "driven", ha="center", va="center")
    shape.set(aspect="equal", title="tension at the end")
    shape.set_axis_off()
    over_time.plot(solution.t, solution["tension"][:, 0], label="of one place of the belt")
    for value, label in ((246.9, "steady belt, eq. (belt-creep)"), (151.2, None)):
        over_time.axhline(value, color="0.5", linewidth=0.8, linestyle=":", label=label)
    over_time.set(xlabel="t, s", ylabel="tension, N", ylim=(100.0, 340.0))
    over_time.grid(True, alpha=0.3)
    over_time.legend(fontsize=8, loc="upper right")
    figure.savefig(path, dpi=120)


def plates(path: Path) -> None:
    """A slit ring under a line load, a strip rolled up by an end moment, a shallow shell under pressure."""
    import flexmb as fmb
    from flexmb import view

    turn, radius = np.linspace(0.0, 2.0 * np.pi, 31), np.linspace(6.0, 10.0, 5)
    flat = np.stack([np.outer(np.cos(turn), radius), np.outer(np.sin(turn), radius)], axis=-1)
    soft = fmb.Material(young=21e6, poisson=0.0, density=1.0)
    ring = fmb.AncfPlate(
        "ring",
        points=np.pad(flat, ((0, 0), (0, 0), (0, 1))),
        thickness=0.03,
        material=soft,
        markers={"end": (1.0, "mean")},
    )
    strip = fmb.AncfPlate.rectangle(
        "strip",
        edges=(16.0, 4.0),
        corner=(0.0, 14.0, 0.0),
        elements=(20, 3),
        thickness=0.03,
        material=soft,
        markers={"end": (1.0, "mean")},
    )
    x = np.linspace(-4.0, 4.0, 9)
    shell = fmb.AncfPlate(
        "shell",
        points=[[(-18.0 + a, b, 4.0 - 0.1 * a * a - 0.1 * b * b) for b in x] for a in x],
        thickness=0.03,
        material=soft,
        shear=True,
    )
    bodies, joints, ground = [], [], {}
    for plate, edges, joint in (
        (ring, ("s0",), fmb.Fixed),
        (strip, ("s0",), fmb.Fixed),
        (shell, ("s0", "s1"), fmb.Spherical),
    ):
        for edge in edges:
            plate, own, held = plate.held(f"{plate.name} {edge}", edge, joint)
            ground, joints = {**ground, **own}, [*joints, *held]
        bodies.append(plate)
    moment = 21e6 * 0.03**3 / 12.0 * 4.0 * 1.5 * np.pi / 16.0
    forces = [
        fmb.PointLoad("P", marker="ring.end", force=(0, 0, 3.2)),
        fmb.PointLoad("M", marker="strip.end", moment=(0, -moment, 0)),
        fmb.Pressure("p", load="shell.pressure", amount=-12.0),
    ]
    view.render(
        fmb.statics(
            fmb.Model(bodies=[fmb.Ground(markers=ground), *bodies], joints=joints, forces=forces, gravity=(0, 0, 0))
        ),
        path,
        size=(1200, 560),
        camera=(0.3, -1.0, 0.7),
    )


def lu_gre(path: Path) -> None:
    """LuGre friction with the data of the paper: below break-away, its lag, break-away over the rate, stick-slip."""
    from forces.test_lu_gre import PULL, SPRING, STRIBECK, paper, sled

    import flexmb as fmb

    fine = fmb.GeneralizedAlpha(rtol=1e-7)
    figure, ((before, lag), (away, slip)) = plt.subplots(2, 2, figsize=(9, 6.4), layout="constrained")

    wave = fmb.expression("1.425*sin(2*t)")
    run = fmb.simulate(
        sled(fmb.Actuator("push", joint="rail", effort=wave)), t_end=2 * np.pi, integrator=fine, samples=601
    )
    before.plot(1e6 * run["x"], 1.425 * np.sin(2 * run.t))
    exact = paper(lambda t, x: 1.425 * np.sin(2.0 * t), 2 * np.pi, at=run.t[::20])
    before.plot(1e6 * exact[0], 1.425 * np.sin(2 * run.t[::20]), "k.", ms=4)
    before.set(xlabel="displacement [µm]", ylabel="force [N]", title="below break-away")

    for speed in (1.0, 10.0, 25.0):
        place = fmb.expression("v*(t - cos(w*t)/w)", v=STRIBECK, w=speed)
        model = sled().with_parts(
            joints=[fmb.Drive("drive", joint="rail", displacement=place)],
            sensors=[fmb.ForceOf("friction", force="rub")],
        )
        period = 2 * np.pi / speed
        run = fmb.simulate(model, t_end=3 * period, integrator=fine, samples=np.linspace(0, 3 * period, 901))
        last = run.t >= (2 - 1e-9) * period
        v = STRIBECK * (1.0 + np.sin(speed * run.t[last]))
        lag.plot(1e3 * v, -run["friction"][last, 2], lw=1.2, label=f"{speed:g} rad/s")
    lag.set(xlabel="speed [mm/s]", ylabel="friction [N]", title="speed that swings")
    lag.legend()

    rates, found = np.geomspace(1.0, 50.0, 9), []
    for rate in rates:
        run = fmb.simulate(
            sled(fmb.Actuator("push", joint="rail", effort=fmb.ramp(rate=rate))),
            t_end=1.7 / rate,
            integrator=fine,
            samples=801,
        )
        exact = paper(lambda t, x, rate=rate: rate * t, 1.7 / rate, at=run.t)
        found.append((1e5 * run["z"].max(), 1e5 * exact[2].max()))
    away.plot(rates, np.array(found)[:, 0])
    away.plot(rates, np.array(found)[:, 1], "k.", ms=4)
    away.set(xlabel="rate of the force [N/s]", ylabel="largest force of the bristles [N]", title="break-away")

    model = sled(
        fmb.Actuator("spring", joint="rail", effort=fmb.table([-50, 50], [50 * SPRING, -50 * SPRING], of="rail")),
        fmb.Actuator("end", joint="rail", effort=fmb.ramp(rate=SPRING * PULL)),
    )
    run = fmb.simulate(model, t_end=20.0, integrator=fine, samples=1001)
    exact = paper(lambda t, x: SPRING * (PULL * t - x), 20.0, at=run.t[::25])
    slip.plot(run.t, run["x"])
    slip.plot(run.t[::25], exact[0], "k.", ms=4, label="equations of the paper, SciPy")
    slip.plot(run.t, PULL * run.t, lw=0.8, color="gray")
    slip.set(xlabel="time [s]", ylabel="place of mass and of the spring's end [m]", title="stick-slip")
    slip.legend()
    for axis in (before, lag, away, slip):
        axis.grid(True, alpha=0.3)
    figure.savefig(path, dpi=120)


def wrap_rib_antenna(path: Path) -> None:
    """The ribs of the antenna from above, wound up, on their way and stretched, and how far the first one reaches."""
    import runpy

    antenna = runpy.run_path(str(FOLDER.parents[1] / "examples" / "wrap_rib_antenna.py"))
    motion = antenna["run"]()
    series, hub = motion.series(), motion["hub"]
    joints = [joint for joint in motion.model.joints if joint.name.startswith("rib")]
    ends = [(joint.markers[1], joint.markers[1].replace("root", "tip")) for joint in joints]
    places = [np.array([series.marker(name).r for name in pair]) - hub for pair in ends]
    figure, (above, over) = plt.subplots(1, 2, figsize=(8.4, 3.6), layout="constrained")
    around = np.linspace(0.0, 2.0 * np.pi, 100)
    above.fill(*antenna["RADIUS"] * np.array([np.cos(around), np.sin(around)]), color="0.85")
    for t, color in ((0.0, "0.55"), (0.8, "C1"), (1.6, "C0")):
        k = int(np.argmin(np.abs(motion.t - t)))
        for n, rod in enumerate(places):
            above.plot(*rod[:, k, :2].T, "o-", color=color, markersize=3, label=None if n else f"{motion.t[k]:.1f} s")
    above.set(xlabel="x from the hub, m", ylabel="y, m", aspect="equal", title="ribs from above")
    stretched = antenna["RADIUS"] + 4 * antenna["SEGMENT"]
    over.plot(motion.t, np.linalg.norm(motion["tip"] - hub, axis=1), label="tip of the first rib from the hub, m")
    over.plot(motion.t, 1e2 * np.linalg.norm(hub - hub[0], axis=1), "--", label="hub from its place, cm")
    over.axhline(stretched, color="0.5", linewidth=0.8, linestyle=":", label="stretched")
    over.set(xlabel="time, s", title="deployment")
    for axis in (above, over):
        axis.grid(True, alpha=0.3)
        axis.legend(fontsize=7)
    figure.savefig(path, dpi=120)


DIAGRAMS = {
    "bases": bases,
    "belt_drive": belt_drive,
    "lu_gre": lu_gre,
    "plates": plates,
    "rod_modes": rod_modes,
    "snapping_strip": snapping_strip,
    "soft_crank": soft_crank,
    "spacecraft": spacecraft,
    "swept_sections": swept_sections,
    "towing_chain": towing_chain,
    "which_body": which_body,
    "wrap_rib_antenna": wrap_rib_antenna,
}


def main() -> None:
    """Draw all diagrams, or those named on the command line."""
    for name in sys.argv[1:] or DIAGRAMS:
        DIAGRAMS[name](FOLDER / f"{name}.png")


if __name__ == "__main__":
    main()
