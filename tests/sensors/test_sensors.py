"""Sensors against a motion in closed form; their messages."""

from dataclasses import KW_ONLY, dataclass, replace

import numpy as np
import pytest
from results.spinning import (
    LENGTH,
    MASS,
    POINT,
    RATE,
    angle_at,
    block_data,
    observe,
    spinning_model,
    spinning_phase,
    spinning_system,
)
from tolerances import MACHINE

from flexmb import sensors
from flexmb.errors import ModelError
from flexmb.model.kinds import Body, Sensor
from flexmb.results import Solution


@pytest.fixture
def solution(monkeypatch):
    monkeypatch.setattr("flexmb.system.observe", observe, raising=False)
    return Solution(phases=(spinning_phase(),))


def test_every_kind_is_listed():
    assert all(issubclass(kind, Sensor) and name == kind.__name__ for name, kind in sensors.KINDS.items())
    assert set(sensors.__all__) - {"KINDS"} == set(sensors.KINDS)


def test_marker_motion(solution):
    t = solution.t
    theta, rate, second = angle_at(t)
    along = np.stack([np.cos(theta), np.sin(theta), 0 * t], 1)
    across = np.stack([-np.sin(theta), np.cos(theta), 0 * t], 1)
    r = solution[sensors.Position("r", marker="rod.end")]
    np.testing.assert_allclose(r, np.array(POINT) + LENGTH * along, rtol=0, atol=MACHINE)
    v = solution[sensors.Velocity("v", marker="rod.end")]
    np.testing.assert_allclose(v, LENGTH * rate[:, None] * across, rtol=0, atol=MACHINE * RATE * LENGTH)
    a = solution[sensors.Acceleration("a", marker="rod.end")]
    expected = LENGTH * (second[:, None] * across - rate[:, None] ** 2 * along)
    np.testing.assert_allclose(a, expected, rtol=0, atol=MACHINE * 1e4)


def test_orientation_is_continuous(solution):
    p = solution[sensors.Orientation("p", marker="rod.end")]
    assert p.shape == (11, 4)
    assert p[0, 0] >= 0.0
    assert np.all(np.einsum("ti,ti->t", p[1:], p[:-1]) >= 0.0)
    theta = angle_at(solution.t)[0]
    np.testing.assert_allclose(np.abs(p[:, 0]), np.abs(np.cos(theta / 2)), atol=MACHINE)


def test_angle_counts_turns_between_coarse_samples(solution):
    """0.7 turns between samples and more: counted by velocity, where numpy.unwrap would lose turns."""
    theta = angle_at(solution.t)[0]
    assert np.diff(theta).min() > np.pi
    values = solution[sensors.JointCoordinate("theta", joint="hinge")]
    np.testing.assert_allclose(values, theta, rtol=MACHINE, atol=MACHINE)


def test_slide(solution):
    np.testing.assert_allclose(solution[sensors.JointCoordinate("s", joint="guide")], 0.5 * solution.t, atol=MACHINE)
    along_z = solution[sensors.JointCoordinate("s", joint="hinge", kind="slide")]
    np.testing.assert_allclose(along_z, 0.0, atol=MACHINE)


def test_loads_energies_and_errors(solution):
    t = solution.t
    reaction = solution[sensors.Reaction("R", joint="weld")]
    np.testing.assert_array_equal(reaction, np.arange(6.0, 12.0) * (1 + t[:, None]))
    for kind, factor in (
        ("kinetic", 1),
        ("strain", 10),
        ("potential", 100),
        ("total", 111),
        ("work_of_loads", 1),
        ("work_of_drives", 2),
        ("dissipated", 3),
    ):
        np.testing.assert_allclose(solution[sensors.Energy("E", kind=kind)], factor * t, rtol=MACHINE)
    for level, factor in (("position", 1.0), ("velocity", 10.0), ("acceleration", 100.0)):
        np.testing.assert_array_equal(solution[sensors.ConstraintError("g", level=level)], 1e-9 * t * factor)
    with pytest.raises(ModelError, match=r"level = 'speed'\. One of: position, velocity, acceleration"):
        sensors.ConstraintError("g", level="speed")


def test_deflection(solution):
    """Modes: stretch eta_1 x and bending eta_2 x^2; at the tip x = 1."""
    t = solution.t
    expected = np.stack([1e-3 * t, 2e-3 * t**2, 0 * t], 1)
    for sensor in (
        sensors.Deflection("d", marker="block.tip"),
        sensors.Deflection("d", marker="block.tip", relative_to="block.root"),
    ):
        np.testing.assert_allclose(solution[sensor], expected, rtol=0, atol=4 * np.finfo(float).eps * 3)


def test_stress(solution):
    """sigma = S eta by hand, von Mises from principal deviators: s_v^2 = 3/2 dev : dev."""
    t = solution.t
    eta = np.stack([1e-3 * t, 2e-3 * t**2], 1)
    sigma = np.einsum("nkj,tj->tnk", block_data().stress_modes, eta)
    tensor = solution[sensors.Stress("s", body="block", node=4, component="tensor")]
    np.testing.assert_allclose(tensor, sigma[:, 4], rtol=MACHINE)
    full = np.zeros((*sigma.shape[:2], 3, 3))
    for k, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))):
        full[..., i, j] = full[..., j, i] = sigma[..., k]
    deviator = full - np.einsum("...ii", full)[..., None, None] / 3 * np.eye(3)
    mises = np.sqrt(1.5 * np.einsum("...ij,...ij", deviator, deviator))
    np.testing.assert_allclose(solution[sensors.Stress("s", body="block")], mises.max(1), rtol=1e-9)
    two = solution[sensors.Stress("s", body="block", node=(1, 2))]
    np.testing.assert_allclose(two, mises[:, 1:3].max(1), rtol=1e-9)
    np.testing.assert_allclose(solution[sensors.Stress("s", body="block", node=2)], mises[:, 2], rtol=1e-9)
    np.testing.assert_allclose(solution[sensors.Stress("s", body="block", component="xy")], sigma[:, :, 3].max(1))


@pytest.mark.parametrize("place", [(0.5, 0.1, 0.5), [0.5, 0.1, 0.5 + 1e-7], np.array([0.5, 0.1, 0.5])])
def test_stress_at_the_place_of_a_node(solution, place):
    """A mesh of a drawing has no numbers that anybody knows; node 8 stands there, 0 and 1 at the corners below."""
    for component in ("von_mises", "tensor"):
        given, by_number = (sensors.Stress("s", body="block", node=n, component=component) for n in (place, 8))
        np.testing.assert_array_equal(solution[given], solution[by_number])
    several = solution[sensors.Stress("s", body="block", node=[(0.0, 0.0, 0.0), (1.0, 0, 0), 8])]
    np.testing.assert_array_equal(several, solution[sensors.Stress("s", body="block", node=[0, 1, 8])])
    corner = solution[sensors.Stress("s", body="block", node=(1.0, 0.0, 0.0))]
    np.testing.assert_array_equal(corner, solution[sensors.Stress("s", body="block", node=1)])


@pytest.mark.parametrize(
    ("node", "told"),
    [
        (
            (0.5, 0.1, 0.45),
            r"no node at \(0.5, 0.1, 0.45\) m; the nearest is 0.05 m away, at \(0.5, 0.1, 0.5\).*node = 8",
        ),
        ((0, 0, 1), r"node = \(0, 0, 1\), three node numbers or a place.*Write \(0.0, 0.0, 1.0\)"),
        ((0.5, 0.1), "the place of a node, m"),
    ],
)
def test_places_without_a_node_are_told(solution, node, told):
    with pytest.raises(ModelError, match=told):
        solution[sensors.Stress("s", body="block", node=node)]


def test_momentum_of_rigid_bodies(solution):
    """Rod about its end: P = m v_c, L_z = (m l^2/3 + terms of the hinge's place) w; the block is left out."""
    model = solution.model.without("weld", "block")
    phase = spinning_phase()
    keep_q, keep_u = np.r_[0:7, 16:23], np.r_[0:6, 14:20]
    phase = replace(
        phase,
        model=model,
        q=phase.q[:, keep_q],
        u=phase.u[:, keep_u],
        a=phase.a[:, keep_u],
        system=spinning_system(model),
    )
    t = phase.t
    theta, rate, _ = angle_at(t)
    center = 0.5 * LENGTH * np.stack([np.cos(theta), np.sin(theta)], 1)
    P = MASS * rate[:, None] * np.stack([-center[:, 1], center[:, 0]], 1)
    lateral = MASS * (LENGTH**2 / 12 + 0.05**2 / 4 + LENGTH**2 / 4)
    momentum = Solution(phases=(phase,))[sensors.Momentum("p")]
    np.testing.assert_allclose(momentum[:, :2], P, rtol=0, atol=1e-10)
    np.testing.assert_allclose(momentum[:, 2], 0.5, rtol=MACHINE)
    expected = lateral * rate + POINT[0] * P[:, 1] - POINT[1] * P[:, 0]
    np.testing.assert_allclose(momentum[:, 5], expected, rtol=1e-12)


def test_momentum_of_a_floating_body_is_the_derivative_of_its_energy(solution):
    """P_v = dT/dv, h = dT/dw with T = 1/2 u^T M_b(eta) u assembled from the invariants one by one."""
    body = solution.model.body("block")
    rng = np.random.default_rng(1)
    I = body.data.invariants
    eta, u = rng.normal(size=2), rng.normal(size=8)
    M = np.zeros((8, 8))
    M[:3, :3], M[3:6, 3:6] = I.vv, I.ww0
    M[:3, 3:6], M[:3, 6:], M[3:6, 6:], M[6:, 6:] = I.vw0, I.vn, I.wn0, I.nn
    for j in range(2):
        M[:3, 3:6] += eta[j] * I.vw1[j]
        M[3:6, 3:6] += eta[j] * I.ww1[j] + sum(eta[j] * eta[k] * I.ww2[j, k] for k in range(2))
        M[3:6, 6:] += eta[j] * I.wn1[j]
    M[3:6, :3], M[6:, :6] = M[:3, 3:6].T, M[:6, 6:].T
    q = np.concatenate([[0, 0, 0, 1, 0, 0, 0], eta])[None]
    np.testing.assert_allclose(body.momentum(q, u[None])[0], (M @ u)[:6], rtol=1e-12)


@dataclass(frozen=True, eq=False)
class Height(Sensor):
    """A kind of one's own, as short as contributors are told."""

    _: KW_ONLY
    marker: str

    def markers_read(self, model):
        return (self.marker,)

    def values(self, series):
        return series.marker(self.marker).r[:, 2]


@pytest.mark.parametrize(
    ("sensor", "message"),
    [
        (sensors.Position("x", marker="rod.ende"), r"Sensor 'x': marker 'rod.ende' does not.*Did you mean 'rod.end'\?"),
        (sensors.Velocity("x", marker="rodd.end"), r"body 'rodd' does not exist.*Did you mean 'rod'\?"),
        (sensors.Velocity("x", marker="rod.end", axes="rod.ends"), r"'rod.ends' does not.*Did you mean 'rod.end'"),
        (sensors.Distance("x", markers=("rod.end", "rod.ende")), r"'rod.ende' does not.*Did you mean 'rod.end'"),
        (
            sensors.AxisCosine("x", markers=("rod.ende", "rod.end"), axes=("x", "y")),
            r"'rod.ende' does not.*Did you mean 'rod.end'",
        ),
        (Height("x", marker="rod.ende"), r"Sensor 'x': marker 'rod.ende' does not.*Did you mean 'rod.end'"),
        (sensors.Reaction("x", joint="hing"), r"joint 'hing' does not exist.*Did you mean 'hinge'\?"),
        (sensors.ForceOf("x", force="push"), r"force 'push' does not exist"),
        (sensors.JointCoordinate("x", joint="hingee"), r"Did you mean 'hinge'\?"),
        (sensors.JointCoordinate("x", joint="weld"), r"joint 'weld' \(Fixed\) neither turns nor slides"),
        (sensors.Deflection("x", marker="ground.hinge"), r"body 'ground' \(Ground\) has no axes of its own"),
        (sensors.Deflection("x", marker="rod.end", relative_to="block.tip"), r"are on two bodies"),
        (sensors.Stress("x", body="rod"), r"body 'rod' \(RigidBody\) has no stress modes"),
        (sensors.Stress("x", body="block", node=9), r"node = 9.*0 to 8"),
    ],
)
def test_messages_of_check(sensor, message):
    with pytest.raises(ModelError, match=message):
        spinning_model(sensors=[sensor])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sensors.Energy("x", kind="kinetik"), r"Did you mean 'kinetic'\?"),
        (lambda: sensors.JointCoordinate("x", joint="hinge", kind="twist"), r"expected|'turn', 'slide' or nothing"),
        (lambda: sensors.Stress("x", body="block", component="mises"), r"One of: von_mises, xx"),
        (lambda: sensors.Stress("x", body="block", component="tensor"), r"the tensor at node = None.*one node number"),
    ],
)
def test_messages_of_fields(make, message):
    with pytest.raises(ModelError, match=message):
        make()


def test_momentum_of_an_unknown_kind(solution):
    class Jelly(Body):
        pass

    with pytest.raises(ModelError, match=r"a Jelly does not provide its momentum"):
        Jelly("jelly").momentum(np.zeros((1, 3)), np.zeros((1, 3)))


def test_titles_carry_units(solution):
    assert sensors.JointCoordinate("x", joint="guide").columns(solution.model) == ("displacement [m]",)
    assert sensors.JointCoordinate("x", joint="hinge").columns(solution.model) == ("angle [rad]",)
    for sensor in (
        sensors.Position("x", marker="rod.end"),
        sensors.Reaction("x", joint="hinge"),
        sensors.Momentum("x"),
        sensors.Orientation("x", marker="rod.end"),
        sensors.Deflection("x", marker="rod.end"),
    ):
        assert len(sensor.columns(solution.model)) == solution[sensor].shape[1]


def test_wrench_in_the_axes_of_a_marker(solution):
    """R^T F, with the same length as F; unknown axes are refused."""
    world = solution[sensors.Reaction("w", joint="hinge")]
    turned = solution[sensors.Reaction("m", joint="hinge", axes="rod.end")]
    R = solution.series().marker("rod.end").R
    back = np.einsum("tij,tj->ti", R, turned[:, :3])
    np.testing.assert_allclose(back, world[:, :3], atol=MACHINE * np.abs(world).max())
    np.testing.assert_allclose(np.linalg.norm(turned[:, 3:], axis=1), np.linalg.norm(world[:, 3:], axis=1), atol=1e-9)
    assert np.abs(turned - world).max() > 0.1 * np.abs(world).max()
    with pytest.raises(ModelError, match=r"rod\.tip"):
        solution[sensors.Reaction("m", joint="hinge", axes="rod.tip")]
