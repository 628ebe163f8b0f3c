"""Contact of cables and beams with planes and cylinders: exact derivatives, closed forms, energy."""

import numpy as np
import pytest
from by_turns import slow
from contracts.random_models import derivative, moved
from tolerances import MACHINE, SOLVER

import flexmb as fmb
from flexmb import fem
from flexmb.errors import ModelError
from flexmb.integrate.matrices import tangent_at
from flexmb.system import compile
from flexmb.system.program import energies, evaluate

KINDS = {"cable": fmb.AncfCable, "beam": fmb.AncfBeam}
SOFT = fmb.Material(young=2e3, poisson=0.3, density=80.0)


def touching(kind, against):
    """A line through space that touches a plane or cylinder of a moving body all along."""
    line = KINDS[kind](
        "b",
        points=((0, 0.4, 0), (1, 0.5, 0.1), (2, 0.4, 0.3)),
        elements=2,
        stretches={"s": (0.1, 0.9)},
        section=fem.Section.solid_circle(0.2),
        material=SOFT,
    )
    drum = fmb.RigidBody(
        "drum",
        mass=2.0,
        inertia=(0.2, 0.3, 0.4),
        at=(1.0, -0.3, 0.2),
        rotation=(0.2, 1.4, -0.1),
        markers={"m": fmb.Pose((0.1, 0.2, 0.1), (0.1, 0.2, 0.3))},
    )
    radius = {"radius": 1.6} if against == "cylinder" else {}
    contact = fmb.LineContact(
        "c",
        stretch="b.s",
        marker="drum.m",
        against=against,
        offset=1.7,
        stiffness=40.0,
        exponent=1.3,
        damping=0.05,
        friction=0.4,
        transition=0.8,
        **radius,
    )
    return (fmb.Ground(), line, drum), contact


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("against", ["plane", "cylinder"])
def test_tangent_and_power(kind, against, rng):
    """K at rest and D in motion are derivatives of the residual, action is reaction, and power is accounted for."""
    bodies, contact = touching(kind, against)
    system, bare = (compile(fmb.Model(bodies=bodies, forces=forces)) for forces in ((contact,), ()))
    state = system.state(0.0)
    state.q[:-7] += 0.02 * rng.normal(size=system.nq - 7)
    work, without = system.workspace(), bare.workspace()

    def residual(there):
        for one, scratch in ((system, work), (bare, without)):
            scratch.weights[0].wanted = 0
            energies(one.program, there, scratch)
        return work.residual - without.residual

    assert np.abs(residual(state)).max() > 1.0  # they touch
    u = rng.normal(size=system.nu)
    fast = state._replace(u=u)
    changes = {
        "K": (state, lambda x, d: moved(system, state, d, x)),
        "D": (fast, lambda x, d: fast._replace(u=u + x * d)),
    }
    for name, (there, change) in changes.items():
        expected = np.array([derivative(lambda x, d=d, c=change: residual(c(x, d)), 1e-3) for d in np.eye(system.nu)]).T
        found = (
            getattr(tangent_at(system, there, work), name) - getattr(tangent_at(bare, there, without), name)
        ).toarray()
        np.testing.assert_allclose(found, expected, atol=SOLVER * np.abs(expected).max(), err_msg=name)

    force = -residual(fast)
    dissipated = work.energy[0].dissipation - without.energy[0].dissipation
    stored = derivative(
        lambda x: (
            residual(moved(system, state, u, x)) is None or work.energy[0].potential - without.energy[0].potential
        ),
        1e-3,
    )
    assert force @ u == pytest.approx(-stored - dissipated, rel=SOLVER)
    assert dissipated > 0.0

    evaluate(system.program, fast, work)
    F, M, r = (work.markers["wrench"][:, :3], work.markers["wrench"][:, 3:], work.markers["r"])
    scale = np.abs(F).sum() * np.abs(r).max()
    np.testing.assert_allclose(F.sum(axis=0), 0.0, atol=10 * MACHINE * scale)
    np.testing.assert_allclose((M + np.cross(r, F)).sum(axis=0), 0.0, atol=10 * MACHINE * scale)


def test_rope_on_the_ground():
    """A rope lifted at one end, the rest on the ground: catenary with touchdown (Irvine, Cable Structures, 1981, ch.
    2).

    With the horizontal tension H and a = H / w, the suspended length is s = sqrt(h^2 + 2 h a) and spans a asinh(s / a).
    """
    weight, stiffness, length, height, tension = 9.81, 1e5, 20.0, 6.0, 40.0

    def catenary(H):
        a = H / weight
        return a, length - np.sqrt(height**2 + 2.0 * height * a)

    a, touch = catenary(60.0)  # as drawn: pulled harder
    place = np.linspace(0.0, length, 81)
    up = np.maximum(place - touch, 0.0)
    drawn = np.column_stack([np.minimum(place, touch) + a * np.arcsinh(up / a), 0.0 * up, np.hypot(a, up) - a])
    rope = fmb.AncfCable(
        "rope",
        points=drawn,
        elements=40,
        straight=True,
        stretches={"all": (0.0, 1.0)},
        section=fem.Section.values(1e-3, 1e-12, 1e-12, 2e-12),
        markers={"lying": 0.25},
        material=fmb.Material(young=1e9, poisson=0.3, density=1000.0),
    )
    a, touch = catenary(tension)
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=(fmb.Ground(), rope),
        joints=(fmb.Spherical("anchor", markers=("ground.origin", "rope.start")),),
        forces=(
            fmb.LineContact("floor", stretch="rope.all", marker="ground.origin", against="plane", stiffness=stiffness),
            fmb.PointLoad("pull", marker="rope.end", force=(tension, 0, weight * (length - touch))),
        ),
        sensors=(
            fmb.Reaction("anchor", joint="anchor"),
            fmb.Position("end", marker="rope.end"),
            fmb.Position("lying", marker="rope.lying"),
            fmb.ForceOf("floor", force="floor"),
        ),
    )
    found = fmb.statics(model)
    end = touch + a * np.arcsinh((length - touch) / a)
    np.testing.assert_allclose(found["end"][-1], (end, 0.0, height), atol=2e-3)
    assert found["anchor"][-1, 0] == pytest.approx(-tension, rel=1e-6)
    assert found["lying"][-1, 2] == pytest.approx(-weight / stiffness, rel=1e-4)  # carried where it lies
    assert -found["floor"][-1, 2] == pytest.approx(weight * touch, rel=5e-3)
    moment = np.cross(
        found["end"][-1], (tension, 0.0, weight * (length - touch))
    )  # about the anchor, with the weight's
    q = found.final.q
    nodes, shares = rope.element_nodes(), rope.element_mass()[1]
    at = q.reshape(-1, 2, 3)[nodes].reshape(rope.elements, 4, 3)
    moment += np.cross(np.einsum("es,esi->i", shares, at), (0.0, 0.0, -9.81))
    np.testing.assert_allclose(moment, found["floor"][-1, 3:], atol=1e-6 * abs(moment[1]))


def capstan(*, elements=20, friction=0.3, speed=20.0, load=100.0):
    """A rope over half a drum that turns under it; one end is held, a load hangs on the other."""
    radius, leg = 0.1, 0.1
    arc, down = np.linspace(0.0, np.pi, 41), leg * np.linspace(0.0, 1.0, 9)[:-1]
    x = np.concatenate([np.full(8, radius), radius * np.cos(arc), np.full(8, -radius)])
    z = np.concatenate([down - leg, radius * np.sin(arc), -down - leg / 8])
    rope = fmb.AncfCable(
        "rope",
        points=np.column_stack([x, 0.0 * x, z]),
        elements=elements,
        straight=True,
        stretches={"all": (0.0, 1.0)},
        section=fem.Section.values(1e-5, 1e-14, 1e-14, 2e-14),
        material=fmb.Material(young=1e10, poisson=0.3, density=1000.0),
        axial_damping=10.0,
    )
    axle = fmb.Pose((0, 0, 0), (0.5 * np.pi, 0, 0))
    drum = fmb.RigidBody.cylinder("drum", radius=radius, length=0.1, density=800.0, markers={"axle": axle})
    return fmb.Model(
        gravity=(0, 0, 0),
        bodies=(fmb.Ground(markers={"axle": axle, "hold": (radius, 0, -leg)}), drum, rope),
        joints=(
            fmb.Revolute("axle", markers=("ground.axle", "drum.axle")),
            fmb.Drive("motor", joint="axle", angle=fmb.ramp(rate=speed)),
            fmb.Spherical("hold", markers=("ground.hold", "rope.start")),
        ),
        forces=(
            fmb.LineContact(
                "contact",
                stretch="rope.all",
                marker="drum.axle",
                radius=radius,
                stiffness=1e7,
                friction=friction,
                transition=0.01,
            ),
            fmb.PointLoad("pull", marker="rope.end", force=(0, 0, -load)),
        ),
        sensors=(
            fmb.Reaction("hold", joint="hold"),
            fmb.ForceOf("contact", force="contact"),
            fmb.Reaction("motor", joint="motor"),
        ),
    )


@pytest.mark.parametrize("sense", [slow(1.0), -1.0])
def test_capstan(sense):
    """T_hold / T_load = exp(mu pi): Euler-Eytelwein; friction at the slip v is mu v / sqrt(v^2 + v0^2).

    The drum feels 2 T_load less what the held end lacks, and the torque of the difference.
    """
    radius, slip = 0.1, 2.0
    found = fmb.simulate(
        capstan(speed=20.0 * sense), t_end=0.1, samples=3, integrator=fmb.GeneralizedAlpha(rho_inf=0.3, rtol=1e-3)
    )
    hold, torque = -found["hold"][-1, 2], found["contact"][-1, 4]
    friction = 0.3 * slip / np.hypot(slip, 0.01)
    assert abs(np.log(hold / 100.0)) == pytest.approx(friction * np.pi, rel=2e-3)
    assert -found["contact"][-1, 2] == pytest.approx(100.0 + hold, rel=1e-5)
    assert abs(torque) == pytest.approx(radius * abs(hold - 100.0), rel=2e-3)  # the rope sinks in by 1e-4 m
    assert abs(found["motor"][-1, 4]) == pytest.approx(abs(torque), rel=1e-6)


def test_energy_with_friction():
    """What the motor and the load put in is stored or goes into friction and damping; friction takes its part."""
    found = fmb.simulate(capstan(), t_end=0.01, samples=11, integrator=fmb.GeneralizedAlpha(rho_inf=0.9, rtol=1e-6))
    series = found.series()
    total = series.energy.sum(axis=1)
    loads, drives, lost = series.works.T
    np.testing.assert_allclose(total - total[0], loads + drives - lost, atol=2e-3 * lost[-1])
    assert lost[-1] > 0.5 * drives[-1] > 0.0


def test_closed_line(rng):
    """The element that closes a belt is one like the others: exact tangent, and a matrix that stays sparse."""

    def ring(elements):
        angle = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
        belt = fmb.AncfCable(
            "b",
            points=np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle]),
            closed=True,
            elements=elements,
            stretches={"s": (0.0, 1.0)},
            material=SOFT,
            section=fem.Section.solid_circle(0.2),
        )
        contact = fmb.LineContact("c", stretch="b.s", marker="ground.origin", radius=1.1, stiffness=40.0)
        return compile(fmb.Model(bodies=(fmb.Ground(), belt), forces=(contact,)))

    system = ring(6)
    state, work = system.state(0.0), system.workspace()
    state.q[:] += 0.02 * rng.normal(size=system.nq)

    def residual(x, d):
        work.weights[0].wanted = 0
        evaluate(system.program, moved(system, state, d, x), work)
        return work.residual.copy()

    expected = np.array([derivative(lambda x, d=d: residual(x, d), 1e-3) for d in np.eye(system.nu)]).T
    found = tangent_at(system, state, work).K.toarray()
    np.testing.assert_allclose(found, expected, atol=SOLVER * np.abs(expected).max())
    sizes = [int(ring(elements).program.pattern.row_start[-1]) for elements in (20, 40)]
    assert sizes[1] < 2.1 * sizes[0]


def test_messages():
    bodies, _ = touching("cable", "plane")

    def with_contact(**fields):
        return fmb.Model(
            bodies=bodies,
            forces=(
                fmb.LineContact(
                    "c", **{"stretch": "b.s", "marker": "drum.m", "stiffness": 1.0, "radius": 0.1} | fields
                ),
            ),
        )

    with_contact()
    with pytest.raises(ModelError, match=r"body 'b' has no stretch 'z'.*One of: s"):
        with_contact(stretch="b.z")
    with pytest.raises(ModelError, match=r"body 'drum' has no stretch.*AncfCable or AncfBeam"):
        with_contact(stretch="drum.s")
    with pytest.raises(ModelError, match=r"stretch = 'b'.*'body\.stretch'"):
        with_contact(stretch="b")
    with pytest.raises(ModelError, match=r"stretch and marker are both on body 'b'"):
        with_contact(marker="b.start")
    with pytest.raises(ModelError, match=r"against a cylinder, radius = None.*a radius for a cylinder"):
        with_contact(radius=None)
    with pytest.raises(ModelError, match=r"against a plane, radius = 0\.1.*none for a plane"):
        with_contact(against="plane")
    with pytest.raises(ModelError, match=r"against = 'cilinder'.*Did you mean 'cylinder'"):
        with_contact(against="cilinder")
    with pytest.raises(ModelError, match=r"stiffness = 0.*a number > 0"):
        with_contact(stiffness=0.0)
    with pytest.raises(ModelError, match=r"exponent = 0\.5"):
        with_contact(exponent=0.5)
