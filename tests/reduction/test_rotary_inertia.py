"""Rotary inertia of nodes: whirling rotors in closed form, discs as bodies, every body frame; rigid turns."""

import numpy as np
import pytest
from fem.beams import plate
from reduction.solids import STEEL
from scipy.linalg import expm

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.reduction.geometric import inertia_loads
from flexmb.reduction.invariants import inertia_invariants

SPIN = 300.0  # rad/s
ALONG = fmb.Pose.axes((0.0, 0.0, 0.0), z=(1.0, 0.0, 0.0))


def shaft(n, length=0.5, section=None, material=STEEL, **options):
    points = np.linspace((0.0, 0.0, 0.0), (length, 0.0, 0.0), n + 1)
    section = section or fem.Section.tube(0.02, 0.006)
    return fem.frame(points, section=section, material=material, **options)


def frequencies(model, below):
    """Imaginary parts of the eigenvalues, seen from the turning shaft."""
    values = np.abs(np.asarray(fmb.linearize(model).eigenvalues).imag)
    return np.unique(values[(values > 1.0) & (values < below)].round(6))


def driven(data, *more, joints=()):
    """A cantilevered shaft, clamped in a hub that spins about x."""
    body = fmb.FloatingBody("shaft", data=data, angular_velocity=(SPIN, 0.0, 0.0), markers={"root": ALONG})
    hinge = fmb.Revolute("hub", markers=("ground.hub", "shaft.root"))
    motor = fmb.Drive("motor", joint="hub", angle=fmb.ramp(rate=SPIN))
    return fmb.Model(bodies=[fmb.Ground(markers={"hub": ALONG}), body, *more], joints=[hinge, motor, *joints])


@pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")  # a shaft without mass to speak of
@pytest.mark.parametrize("frame", ["buckens", "root", "tip"])
def test_overhung_disc(frame):
    """m z'' + k11 z + k12 f = 0, Jt f'' - i Jp W f' + k12 z + k22 f = 0 (z = y + i z, f its slope; Genta, Dynamics of
    Rotating Systems, sec. 2.6), k of a cantilever with shear; seen from the shaft the whirls w are |w - W|."""
    light = fmb.Material(young=210e9, poisson=0.3, density=7850e-6)
    mass, polar, transverse = 5.0, 0.05, 0.03
    fe = fem.with_mass(shaft(4, material=light), "end", mass, (polar, transverse, transverse))
    data = reduction.reduce(
        fe, {"root": "start", "tip": "end"}, modes=0, frame=frame, geometric_stiffness=True, compare=0
    )
    section, L = fem.Section.tube(0.02, 0.006), 0.5
    bend, shear = light.young * section.inertia_y, light.shear * section.area * section.shear_y
    flexibility = [[L**3 / (3 * bend) + L / shear, L**2 / (2 * bend)], [L**2 / (2 * bend), L / bend]]
    M, K = np.diag([mass, transverse]), np.linalg.inv(flexibility)
    first = np.block(
        [[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), np.diag([0.0, 1j * polar * SPIN / M[1, 1]])]]
    )
    whirl = np.linalg.eigvals(first).imag
    np.testing.assert_allclose(frequencies(driven(data), 1e3)[[0, 2, 3, 4]], np.sort(np.abs(whirl - SPIN)), rtol=1e-5)


@pytest.mark.parametrize("frame", ["buckens", "root", "disc"])
def test_two_discs_as_masses_and_as_bodies(frame):
    """Discs of the FE model and rigid bodies fixed to its nodes are one rotor."""
    plain, inertia = shaft(6), {"disc": (4.0, (0.05, 0.03, 0.03)), "other": (2.0, (0.02, 0.015, 0.012))}
    interfaces = {"root": "start", "disc": "end", "other": [4]}
    options = {"modes": 4, "geometric_stiffness": True, "compare": 0, "frame": frame}
    loaded = fem.with_mass(fem.with_mass(plain, "end", *inertia["disc"]), 4, *inertia["other"])
    found = frequencies(driven(reduction.reduce(loaded, interfaces, **options)), 3e3)
    data = reduction.reduce(plain, interfaces, **options)
    at = dict(zip(data.marker_names, data.marker_positions, strict=True))
    discs = [
        fmb.RigidBody(name, mass=mass, inertia=own, at=at[name], angular_velocity=(SPIN, 0.0, 0.0))
        for name, (mass, own) in inertia.items()
    ]
    held = [fmb.Fixed(name, markers=(f"shaft.{name}", f"{name}.center")) for name in inertia]
    np.testing.assert_allclose(found, frequencies(driven(data, *discs, joints=held), 3e3), rtol=2e-5)


@pytest.mark.parametrize("frame", ["buckens", "a", "b"])
def test_hollow_rotor(frame):
    """Rayleigh's rotating shaft on hinges: w2 (A + I k2) - 2 I k2 W w - (E / rho) I k4 = 0, k = pi / L."""
    section, k = fem.Section.tube(0.2, 0.005), np.pi
    fe = shaft(16, 1.0, section, shear=False)
    data = reduction.reduce(fe, {"a": "start", "b": "end"}, modes=4, frame=frame, geometric_stiffness=True, compare=0)
    far = fmb.Pose.axes((1.0, 0.0, 0.0), z=(1.0, 0.0, 0.0))
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"A": (0.0, 0.0, 0.0), "B": far}),
            fmb.FloatingBody("shaft", data=data, angular_velocity=(SPIN, 0.0, 0.0)),
        ],
        joints=[
            fmb.Spherical("A", markers=("ground.A", "shaft.a")),
            fmb.InLine("B", markers=("ground.B", "shaft.b")),
        ],
    )
    A, I = section.area, section.inertia_y
    forward, backward = np.roots([A + I * k**2, -2.0 * I * k**2 * SPIN, -STEEL.young / STEEL.density * I * k**4])
    found = frequencies(model, 4e3)
    np.testing.assert_allclose(found, [forward - SPIN, SPIN - backward], rtol=3e-4)
    split = (found[0] + SPIN) - (found[1] - SPIN)
    assert split == pytest.approx(forward + backward, rel=2e-3)


MODELS = {
    "frame": lambda: shaft(3),
    "frame out of axis": lambda: fem.frame(
        [(0, 0, 0), (0.3, 0.2, 0.1), (0.4, 0.5, 0.0)], section=fem.Section.rectangle(0.02, 0.05), material=STEEL
    ),
    "masses": lambda: fem.with_mass(shaft(3, lumped=True), "end", 2.0, (0.01, 0.02, 0.025), offset=(0.1, 0.05, -0.07)),
    "shells": lambda: fem.shell(plate(3, 2, 1.0, 0.4, "quad"), STEEL, 0.05),
}


@pytest.mark.parametrize("kind", MODELS)
def test_a_rigid_turn_turns_the_inertia(kind, rng):
    """Shapes that are rigid turns d: M_ww changes by d~ J - J d~, the first moment S by d x S, to first order."""
    fe = MODELS[kind]()
    i = inertia_invariants(fe, fe.rigid_motions()[:, 3:])
    tilde = np.array([np.cross(axis, np.eye(3)).T for axis in np.eye(3)])
    size = np.abs(i.ww0).max()
    np.testing.assert_allclose(
        i.ww1, tilde @ i.ww0 - i.ww0 @ tilde, atol=5e-3 * size if "frame" in kind else 1e-9 * size
    )
    moment = np.array([i.vw0[1, 2], i.vw0[2, 0], i.vw0[0, 1]])  # M_vw = -S~
    np.testing.assert_allclose(
        i.vw1, -np.array([np.cross(np.cross(d, moment), np.eye(3)).T for d in np.eye(3)]), atol=1e-9
    )


def test_spin_about_any_axis_is_in_equilibrium(rng):
    """The inertia loads of B = w~ w~ have the moment -w x J w of the body, rotary inertia included."""
    fe = fem.with_mass(shaft(3, lumped=True), "end", 2.0, (0.5, 0.2, 0.3))
    w = rng.standard_normal(3)
    B = np.outer(w, w) - w @ w * np.eye(3)
    moment = fe.rigid_motions()[:, 3:].T @ inertia_loads(fe)[:, 3:] @ B.ravel()
    J = inertia_invariants(fe, np.zeros((fe.ndof, 0))).ww0
    np.testing.assert_allclose(moment, -np.cross(w, J @ w), rtol=1e-9)


def exact_mass_matrix(fe, shapes, eta):
    """M_b of nodes that are rigid bodies, turned by exp(theta), T(theta) theta' + w their spin: nothing left out."""
    n, m = len(fe.nodes), shapes.shape[1]
    masses, field = fe.M.toarray().reshape(n, 6, n, 6), fe.field(shapes)
    matrix = np.zeros((6 + m, 6 + m))
    for k in range(n):
        x, theta = fe.nodes[k] + field[k, :3] @ eta, field[k, 3:] @ eta
        tilde = np.cross(theta, np.eye(3)).T
        E, angle = expm(tilde), np.linalg.norm(theta)
        T = np.eye(3) + (1 - np.cos(angle)) / angle**2 * tilde + (angle - np.sin(angle)) / angle**3 * tilde @ tilde
        V = np.zeros((6, 6 + m))
        V[:3, :3], V[:3, 3:6], V[:3, 6:] = np.eye(3), -np.cross(x, np.eye(3)).T, field[k, :3]
        V[3:, 3:6], V[3:, 6:] = np.eye(3), T @ field[k, 3:]
        own = np.zeros((6, 6))
        own[:3, :3], own[3:, 3:] = masses[k, :3, k, :3], E @ masses[k, 3:, k, 3:] @ E.T
        matrix += V.T @ own @ V
    return matrix


def test_masses_turn_with_their_nodes(rng):
    """First and second derivatives of the exact mass matrix by differences are the invariants."""
    inertia = np.diag([0.5, 0.3, 0.4]) + 0.05 * (np.ones((3, 3)) - np.eye(3))
    fe = fem.with_mass(shaft(3, lumped=True), 2, 2.0, inertia)
    shapes = rng.standard_normal((fe.ndof, 2))
    i, h = inertia_invariants(fe, shapes), 1e-4
    at = lambda a, b: exact_mass_matrix(fe, shapes, np.array([a, b]))  # noqa: E731
    along = (at(h, 0.0) - at(-h, 0.0)) / (2 * h)
    size = np.abs(along).max()
    np.testing.assert_allclose(along[:3, 3:6], i.vw1[0], atol=1e-6 * size)
    np.testing.assert_allclose(along[3:6, 3:6], i.ww1[0], atol=1e-6 * size)
    np.testing.assert_allclose(along[3:6, 6:], i.wn1[0], atol=1e-6 * size)
    mixed = (at(h, h) - at(h, -h) - at(-h, h) + at(-h, -h))[3:6, 3:6] / (4 * h * h)
    np.testing.assert_allclose(mixed, i.ww2[0, 1] + i.ww2[1, 0], atol=1e-5 * size)
