"""Campaign over models whose numbers are extreme: each ends in a limited time, or says how long it takes."""

from __future__ import annotations

import random
import re
import warnings
from itertools import product
from pathlib import Path

from fuzz.campaign import Campaign
from fuzz.mutation import generator

import flexmb as fmb
from flexmb import io
from flexmb.errors import IntegrationError

__all__ = ["extreme_campaign", "use"]

_NUMBER = re.compile(r"(?<![\w.\"])[-+]?\d+\.?\d*(?:e[-+]?\d+)?(?![\w.])")

HEAD = """
gravity = [0, 0, -9.81]
[[body]]
kind = "Ground"
markers = { A = [0, 0, 0], D = [0.3, 0, 0] }
"""

PENDULUM = """
[[body]]
kind = "RigidBody"
name = "bar"
mass = 1.5
inertia = [1e-3, 2e-2, 2e-2]
at = [0.5, 0, 0]
velocity = [0, 0, 0]
angular_velocity = [0, 0, 0]
markers = { A = [-0.5, 0, 0], B = [0.5, 0, 0] }
[[joint]]
kind = "Revolute"
name = "hinge"
markers = ["ground.A", "bar.A"]
"""

SPRING = """
[[body]]
kind = "PointMass"
name = "stone"
mass = 2.0
at = [0.1, 0.2, 0.3]
velocity = [1.0, 0, 0]
[[force]]
kind = "SpringDamper"
name = "spring"
markers = ["ground.A", "stone.center"]
stiffness = 1000.0
damping = 1.5
length = 0.2
"""

ROTOR = """
[[joint]]
kind = "Drive"
name = "motor"
joint = "hinge"
angle = { ramp = { rate = 30.0, rise = 0.2 } }
"""

LOADS = """
[[force]]
kind = "PointLoad"
name = "push"
marker = "bar.B"
force = [{ harmonic = { amplitude = 10.0, frequency = 4.0 } }, 0.5, { table = { x = [0.0, 0.5], y = [0.0, 5.0] } }]
[[force]]
kind = "BiStop"
name = "stop"
joint = "hinge"
travel = [-0.5, 0.5]
stiffness = 1e4
damping = 1.0
depth = 1e-3
"""

CABLE = """
[[body]]
kind = "AncfCable"
name = "rope"
points = [[0, 0, 0], [1.0, 0, 0]]
elements = 3
section = { kind = "Section.solid_circle", diameter = 0.02 }
material = { kind = "Material", young = 1e8, poisson = 0.3, density = 1000.0 }
[[joint]]
kind = "Spherical"
name = "end"
markers = ["ground.A", "rope.start"]
"""

EVENTS = """
[[sensor]]
kind = "Position"
name = "place"
marker = "stone.center"
[[event]]
kind = "Event"
name = "low"
sensor = "place"
below = 0.1
column = 2
then = [{ kind = "Change", part = "spring", stiffness = 500.0 }]
"""

CONTACT = """
[[force]]
kind = "Contact"
name = "floor"
markers = ["ground.A", "stone.center"]
radius = 0.1
stiffness = 1e5
damping = 10.0
friction = 0.2
"""

SIMULATION = """
[simulation]
t_end = 0.2
samples = 21
"""

TIME_LIMIT = 10.0
"""s, of a run: what is long and honest work ends there, and may be continued."""

INTEGRATORS = (
    "",
    "integrator = { kind = 'GeneralizedAlpha', rho_inf = 0.8, step = 1e-3 }\n",
    "integrator = { kind = 'GeneralizedAlpha', rho_inf = 0.5, rtol = 1e-4 }\n",
    "integrator = { kind = 'IDA', rtol = 1e-5 }\n",
    "integrator = 'Explicit'\n",
)

MODELS = (
    HEAD + PENDULUM,
    HEAD + SPRING,
    HEAD + PENDULUM + ROTOR,
    HEAD + PENDULUM + LOADS,
    HEAD + SPRING + EVENTS,
    HEAD + SPRING + CONTACT,
    HEAD + CABLE,
)


def extreme_campaign(*, seed: int = 1, limit: float = 20.0) -> Campaign:
    """Return the campaign over small models with one to three numbers from 1e-300 to 1e300."""

    def make(folder: Path, k: int) -> Path:
        rng = generator(seed, k)
        text = rng.choice(MODELS) + SIMULATION + rng.choice(INTEGRATORS)
        for _ in range(rng.choice((1, 1, 2, 3))):
            match = rng.choice(list(_NUMBER.finditer(text)))
            text = text[: match.start()] + _extreme(rng) + text[match.end() :]
        path = folder / "case.toml"
        path.write_text(text)
        return path

    def warm(folder: Path) -> list[Path]:
        paths = [folder / f"sound_{i}_{j}.toml" for i in range(len(MODELS)) for j in range(len(INTEGRATORS))]
        for path, (model, integrator) in zip(paths, product(MODELS, INTEGRATORS), strict=True):
            path.write_text(model + SIMULATION + integrator)
        return paths

    return Campaign("extremes", lambda folder: None, make, use, limit=limit, may_be_long=True, warm=warm)


def _extreme(rng: random.Random) -> str:
    exponent = rng.choice((rng.uniform(-300, 300), rng.uniform(-20, 20), rng.uniform(5, 10)))
    return rng.choice((f"{10.0**exponent:.6g}", f"-{10.0**exponent:.6g}", f"{10.0**exponent:.6g}", "0.0", "1e308", "7"))


def use(path: Path) -> None:
    """Check and simulate a model as its file says."""
    model = io.load_model(path)
    settings = io.load_simulation(path)
    fmb.check(model)
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.SlowRunWarning)  # it says that it takes long, and how long
        try:
            fmb.simulate(model, **settings.keywords(), time_limit=TIME_LIMIT)
        except fmb.SlowRunWarning as told:
            raise IntegrationError(f"Model '{model.name}'", found=str(told)) from None
