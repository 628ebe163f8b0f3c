"""A new kind is one file and one line: a copy of the package gets one of each family, and knows them all."""

import os
import shutil
import subprocess
import sys

import pytest
from architecture.sources import ROOT

STATEFUL = (ROOT / "tests" / "maxwell_force.py").read_text(encoding="utf-8")
JOINT = '''
from dataclasses import dataclass
from flexmb.constraints import Coincident, Perpendicular, Turn
from flexmb.model.kinds import Joint

@dataclass(frozen=True, eq=False)
class Latch(Joint):
    """Let marker b turn about the z-axis of marker a, as a latch does."""

    forbids = (Coincident(), Perpendicular("z", "x"), Perpendicular("z", "y"))
    permits = (Turn("z"),)
'''
FORCE = '''
from dataclasses import KW_ONLY, dataclass
from typing import ClassVar
import numpy as np
from flexmb.math.tables import row_kernel
from flexmb.model.kinds import Force
from flexmb.model.table import Table

ROW = np.dtype([("marker", np.int64), ("thrust", float)], align=True)

@row_kernel
def apply(raw, data, state, work):
    """Push along x of W."""
    rows = raw.view(ROW)
    for n in range(rows.shape[0]):
        work.markers[rows[n].marker].wrench[0] += rows[n].thrust

@dataclass(frozen=True, eq=False)
class Rocket(Force):
    """Push a marker along x of W."""

    _: KW_ONLY
    marker: str
    thrust: float

    table: ClassVar[Table] = Table("Rocket", ROW, {"apply": apply})

    def record(self, compiler):
        return {"marker": compiler.marker(self.marker)}
'''
BODY = '''
from dataclasses import dataclass
from flexmb.bodies.point_mass import PointMass

@dataclass(frozen=True, eq=False)
class Pellet(PointMass):
    """A particle."""
'''
SENSOR = '''
from dataclasses import KW_ONLY, dataclass
from typing import ClassVar
from flexmb.model.kinds import Sensor

@dataclass(frozen=True, eq=False)
class Clock(Sensor):
    """The time."""

    titles: ClassVar[tuple[str, ...]] = ("t [s]",)

    def values(self, series):
        return series.t
'''
INTEGRATOR = '''
from dataclasses import dataclass
from flexmb.integrate.explicit.explicit import Explicit

@dataclass(frozen=True, kw_only=True)
class Patient(Explicit):
    """Explicit with another name."""
'''
FORMAT = '''
from flexmb.fem.meshes.groups import from_gmsh

def from_other(path):
    """Read a mesh in the format of Gmsh under another suffix."""
    return from_gmsh(path)
'''
NEW = {
    "joints": (("latch", JOINT, "from flexmb.joints.latch import Latch"),),
    "forces": (
        ("rocket", FORCE, "from flexmb.forces.rocket import Rocket"),
        ("maxwell", STATEFUL.partition("annotations\n")[2], "from flexmb.forces.maxwell import Maxwell"),
    ),
    "bodies": (("pellet", BODY, "from flexmb.bodies.pellet import Pellet"),),
    "sensors": (("clock", SENSOR, "from flexmb.sensors.clock import Clock"),),
    "integrate": (("patient", INTEGRATOR, "from flexmb.integrate.patient import Patient"),),
}
USE = """
import sys
import numpy as np
import flexmb as fmb
from flexmb import fem, io
assert fmb.__file__.startswith(sys.argv[1])

model = fmb.Model(
    gravity=(0, 0, -9.81),
    bodies=[
        fmb.Ground(markers={"O": (0, 0, 0)}),
        fmb.RigidBody.rod("arm", length=1.0, mass=2.0),
        fmb.Pellet("pellet", mass=2.0),
    ],
    joints=[fmb.Latch("latch", markers=("ground.O", "arm.start"))],
    forces=[
        fmb.Rocket("rocket", marker="pellet.center", thrust=6.0),
        fmb.Maxwell("damper", marker="pellet.center", stiffness=8.0, damping=4.0, start=0.25),
    ],
    sensors=[fmb.Clock("clock"), fmb.Position("path", marker="pellet.center")],
)
text = io.model_text(model)
twin = io.read_model_text(text)
found = [type(part) for part in (twin.joints[0], *twin.forces, twin.bodies[2], twin.sensors[0])]
assert found == [fmb.Latch, fmb.Rocket, fmb.Maxwell, fmb.Pellet, fmb.Clock], found
assert {"Latch", "Rocket", "Maxwell", "Pellet", "Clock", "Patient"} <= set(fmb.__all__)
assert io.kind_lists.integrators()["Patient"] is fmb.Patient
try:
    fmb.simulate(model, 1.0, integrator="Pacient")
except fmb.ModelError as error:
    assert "Patient(...)" in str(error) and "integrator=flexmb.Patient()" in str(error), error
else:
    raise AssertionError("a text is no integrator")
there = fmb.accelerations(twin)
# the thrust of 6 N and the spring, drawn 0.25 m at the start by its state, on 2 kg
assert np.allclose(there["pellet"][:3], (0.5 * (6.0 + 8.0 * 0.25), 0.0, -9.81), atol=1e-12), there["pellet"]
# the hinge is upright, so a rod along x rests on it
assert np.allclose(there["arm"], 0.0, atol=1e-9), there["arm"]
mesh = fem.read_mesh(sys.argv[2])
assert len(mesh.points) > 3

sys.path[:0] = [sys.argv[3], sys.argv[3] + "/images"]
import draw_joints
import joint_entries
assert "### Latch\\n" in joint_entries.entries()
draw_joints.with_markers("Latch").save("latch.png")
draw_joints.with_markers("Revolute").save("revolute.png")
assert open("latch.png", "rb").read() == open("revolute.png", "rb").read()  # it permits the same
print("known")
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """Return a folder with a copy of the package, and the files that were touched for each family."""
    folder = tmp_path_factory.mktemp("copy")
    shutil.copytree(ROOT / "flexmb", folder / "flexmb", ignore=shutil.ignore_patterns("__pycache__"))
    touched = {}
    for room, name, code, line in ((room, *kind) for room, kinds in NEW.items() for kind in kinds):
        new, room_file = folder / "flexmb" / room / f"{name}.py", folder / "flexmb" / room / "__init__.py"
        new.write_text(f'"""A kind for the test."""\nfrom __future__ import annotations\n{code}', encoding="utf-8")
        head, rest = room_file.read_text(encoding="utf-8").split("\n\n", 1)
        room_file.write_text(f"{head}\n\n{line}\n{rest}", encoding="utf-8")
        touched[name] = [new, room_file]
    new, door = (folder / "flexmb" / "fem" / "meshes" / file for file in ("other_mesh.py", "read_mesh.py"))
    new.write_text(f'"""A format for the test."""\n{FORMAT}', encoding="utf-8")
    text = door.read_text(encoding="utf-8")
    text = text.replace('    ".msh": from_gmsh,\n', '    ".msh": from_gmsh,\n    ".other": from_other,\n')
    text = text.replace(
        "\nfrom flexmb.fem.meshes.mesh ",
        "\nfrom flexmb.fem.meshes.other_mesh import from_other\nfrom flexmb.fem.meshes.mesh ",
    )
    door.write_text(text, encoding="utf-8")
    touched["mesh format"] = [new, door]
    return folder, touched


def test_every_family_takes_a_kind_with_two_files(package, tmp_path):
    folder, touched = package
    original = {p.relative_to(ROOT): p.read_bytes() for p in (ROOT / "flexmb").rglob("*.py")}
    changed = [p for p in (folder / "flexmb").rglob("*.py") if original.get(p.relative_to(folder)) != p.read_bytes()]
    assert sorted(changed) == sorted({path for paths in touched.values() for path in paths})
    assert {len(paths) for paths in touched.values()} == {2}
    mesh = tmp_path / "cube.other"
    shutil.copy(min((ROOT / "meshes").glob("*.msh"), key=lambda p: p.stat().st_size), mesh)
    run = subprocess.run(
        [sys.executable, "-c", USE, str(folder), str(mesh), str(ROOT / "docs")],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(folder)},
    )
    assert run.stdout == "known\n", run.stderr[-2000:]
