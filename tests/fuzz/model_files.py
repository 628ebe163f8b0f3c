"""Campaign over model files: every kind of part, expressions, assemblies; damaged, and hostile by construction."""

from __future__ import annotations

import os
import random
import shutil
from pathlib import Path

from contracts import every_kind
from fuzz.campaign import Campaign
from fuzz.data_files import reduced
from fuzz.mutation import generator, mutant

import flexmb as fmb
from flexmb import io

__all__ = ["hostile", "model_campaign", "use"]

CRANK = """
name = "crank"
gravity = [0, 0, -9.81]
parameters_from = [{ file = "shared.toml", table = "crank" }]

[parameters]
radius = 0.05
rate = "= 60/radius*0.025"
blade = ["= radius", 0, 0.1]
which = "crank"
rigid = true

[signals]
wind = { table = { x = [0, 1, 2], y = [0, 5, 4] } }
gust = { sum = [{ harmonic = { amplitude = 2, frequency = 4 } }, "= wind", 3] }

[[body]]
kind = "Ground"
markers = { A = { at = [0.1, 0, 0], z = [1, 0, 0] }, ramp = { at = [0, 0, "= 2*radius"] } }

[[body]]
kind = "RigidBody"
name = "= which"
if = "= rigid"
mass = "= shared_mass"
inertia = [1e-5, 1.3e-4, 1.3e-4]
at = [0.1, "= radius", 0]
rotation = [0, "= 90*deg", 0]
[body.markers]
A = { at = [0, "= -radius", 0] }
tip = "= blade"

[[joint]]
kind = "Revolute"
name = "A"
markers = ["ground.A", "crank.A"]

[[joint]]
kind = "Drive"
name = "motor"
joint = "A"
angle = { ramp = { rate = "= rate", rise = 0.2 } }

[[force]]
kind = "PointLoad"
name = "push"
marker = "crank.tip"
force = ["= gust", "= 3*sin(rate*t) + where(t > 0.5, 1, smooth(t))", { sum = [
    { step = { value = 2, rise = 0.1 } },
    { table = { x = [0, 1], y = [0, 5], kind = "linear" } },
    { product = [2, { expression = { text = "a*t", parameters = { a = 3 } } }] },
] }]

[[sensor]]
kind = "Reaction"
name = "bearing"
joint = "A"

[[event]]
kind = "Event"
name = "late"
sensor = "bearing"
above = 5
column = 1
then = [{ kind = "Change", part = "crank", mass = 2 }, { kind = "Stop" }]

[simulation]
t_end = "= 2*pi/rate"
samples = 101
integrator = { kind = "GeneralizedAlpha", rho_inf = 0.8, step = 1e-3 }
start = "equilibrium"
"""

SHARED = """
[crank]
shared_mass = 0.16
[[crank.shaft]]
d = 0.05
"""

TRACK = """
[parameters]
span = 1.0
[[body]]
kind = "Ground"
markers = { A = [0, 0, 0] }
[[body]]
kind = "PointMass"
name = "wheel"
mass = "= span"
at = ["= span", 0, 0]
[[force]]
kind = "SpringDamper"
name = "spring"
markers = ["ground.A", "wheel.center"]
stiffness = 1e3
damping = 1
"""

WING = """
base = "base.toml"
[parameters]
count = 2
[[assembly]]
file = "track.toml"
prefix = "t1"
at = [0, "= count", 0]
parameters = { span = 1.2 }
[[assembly]]
file = "track.toml"
prefix = "t2"
inherit = true
rotation = [0, 0, "= 30*deg"]
[[sensor]]
kind = "Position"
name = "place"
marker = "t1_wheel.center"
[simulation]
t_end = 0.1
integrator = "IDA"
"""

BASE = """
name = "base"
gravity = [0, 0, -9.81]
[parameters]
count = 3
span = "= 0.5*count"
"""


def model_campaign(*, seed: int = 1, limit: float = 10.0) -> Campaign:
    """Return the campaign over model files: nine of ten are damaged, one is hostile by construction."""
    seeds: list[Path] = []

    def make(folder: Path, k: int) -> Path:
        if not seeds:
            seeds.extend(sorted((folder / "seeds").glob("*.toml")))
        rng = generator(seed, k)
        path = folder / "case.toml"
        if k % 10 == 9:
            path.write_text(hostile(rng, folder))
        else:
            own = seeds[:2] if rng.random() < 0.3 else seeds  # the two with expressions and assemblies
            path.write_bytes(mutant(rng.choice(own).read_bytes(), rng, values=True))
        return path

    def warm(folder: Path) -> list[Path]:
        return [shutil.copy(path, folder / path.name) for path in sorted((folder / "seeds").glob("*.toml"))]

    return Campaign("models", _prepare, make, use, limit=limit, warm=warm)


def use(path: Path) -> None:
    """Do with a model file what a user does before a run."""
    model = io.load_model(path)
    repr(model)
    bodies = {body.name: body.data for body in model.bodies if hasattr(body, "data")}
    io.read_model_text(io.model_text(model), bodies)
    fmb.check(model)
    if "[simulation]" in path.read_text(encoding="utf-8"):
        io.load_simulation(path)


_NO_FILES = ("/dev/zero", "/dev/stdin", "/dev/tty", "pipe", ".", "/proc/self/mem")


def hostile(rng: random.Random, folder: Path) -> str:
    """Return a model file that asks for too much: depth, chains, doubling, files that are none."""
    n = rng.choice((10, 100, 600, 1500, 5000, 50_000))
    way = rng.randrange(12)
    if way == 0:
        return "[parameters]\na = " + "[" * n + "]" * n
    if way == 1:
        rows = [f'p{k} = "= p{k + 1} + 1"' for k in range(min(n, 5000))]
        return "[parameters]\n" + "\n".join([*rows, f"p{len(rows)} = 1"])
    if way == 2:
        chain = min(n, 1500)
        for k in range(chain):
            (folder / f"chain{k}.toml").write_text(f'base = "chain{k + 1}.toml"\n' if k < chain - 1 else "name='end'")
        return 'base = "chain0.toml"\n'
    if way == 3:
        depth = min(n, 600)
        for k in range(depth):
            inner = f'[[assembly]]\nfile = "nest{k + 1}.toml"\nprefix = "a"\n' if k < depth - 1 else ""
            (folder / f"nest{k}.toml").write_text(f'[[body]]\nkind = "PointMass"\nname = "m"\nmass = 1.0\n{inner}')
        return '[[assembly]]\nfile = "nest0.toml"\nprefix = "x"\n'
    if way == 4:
        return f'parameters_from = "{rng.choice(_NO_FILES)}"\n'
    if way == 5:
        m = rng.choice((10, 25, 40))
        rows = [f's{k + 1} = {{ sum = ["= s{k}", "= s{k}"] }}' for k in range(m)]
        return "[signals]\ns0 = { ramp = { rate = 1 } }\n" + "\n".join(rows)
    if way == 6:
        m = rng.choice((10, 25, 40))
        rows = [f'l{k + 1} = ["= l{k}", "= l{k}"]' for k in range(m)]
        return "[parameters]\nl0 = [1, 2]\n" + "\n".join(rows)
    if way == 7:
        body = '[[body]]\nkind = "PointMass"\nname = "m"\nmass = 1.0\n'
        return body + f"[simulation]\nt_end = 1.0\nsamples = {rng.choice((10**4, 2 * 10**9, 10**300))}\n"
    if way == 8:
        return f'[parameters]\na = "= {"(" * n}1{")" * n}"\n'
    if way == 9:
        name = "n" * n
        return (
            f'[[body]]\nkind = "PointMass"\nname = "{name}"\nmass = 1.0\n[[joint]]\nkind = "Fixed"\nname = "{name}"\n'
        )
    if way == 10:
        (folder / "twice.toml").write_text('[[body]]\nkind = "PointMass"\nname = "m"\nmass = 1.0\n')
        previous = "twice.toml"
        for k in range(rng.choice((4, 20))):
            both = "".join(f'[[assembly]]\nfile = "{previous}"\nprefix = "{p}"\n' for p in "ab")
            previous = f"twice{k}.toml"
            (folder / previous).write_text(both)
        return f'[[assembly]]\nfile = "{previous}"\nprefix = "x"\n'
    return "[a" + ".a" * n + "]\nb = 1\n"


def _prepare(folder: Path) -> None:
    """Write the files that the seeds name, and the seeds: two by hand and one of every kind."""
    data = reduced()
    data.save(folder / "body.h5")
    seeds = folder / "seeds"
    seeds.mkdir()
    for name, text in (("shared", SHARED), ("track", TRACK), ("base", BASE)):
        (folder / f"{name}.toml").write_text(text)
    (seeds / "0_crank.toml").write_text(CRANK)
    (seeds / "0_wing.toml").write_text(WING)
    os.mkfifo(folder / "pipe")
    ground = every_kind.stage(data)
    for table, name in every_kind.KINDS:
        model, part = every_kind.model_with(table, name, ground, data)
        io.save_model(_small(model, table, part), folder / f"{table}_{name}.toml")
        (folder / f"{table}_{name}.toml").rename(seeds / f"{table}_{name}.toml")


def _small(model: fmb.Model, table: str, part) -> fmb.Model:
    """Return the model without the bodies that the part does not need: most of them take longest."""
    for name in ("sheet", "rope", "flexible"):
        if part.name == name or f"{name}." in repr(part.fields()) or getattr(part, "body", "") == name:
            continue
        skins = [s.name for s in model.surfaces if getattr(s, "skin", "").startswith(f"{name}.")]
        if any(skin in repr(part.fields()) for skin in skins):
            continue
        model = model.without(name, *skins)
    return model
