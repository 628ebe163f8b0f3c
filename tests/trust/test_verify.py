"""`verify`: its estimates are compared with the true error of a run whose solution is known in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

import flexmb as fmb
from flexmb import fem, reduction

G, LENGTH = 9.81, 0.7
START = 2.0  # rad from hanging


def pendulum(**sensors) -> fmb.Model:
    """A point mass on a rod without mass, released at rest from a large angle."""
    place = (LENGTH * np.sin(START), 0.0, -LENGTH * np.cos(START))
    return fmb.Model(
        name="pendulum",
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(markers={"O": (0, 0, 0)}), fmb.PointMass("bob", mass=0.4, at=place)],
        joints=[fmb.Rod("rod", markers=("ground.O", "bob.center"), length=LENGTH)],
        sensors=[fmb.Position("place", marker="bob.center"), fmb.Reaction("pull", joint="rod")],
    )


def exact(t) -> np.ndarray:
    """Place of the bob: sin(phi/2) = k sn(K - w t, k), k = sin(phi0/2) (Lamb, Dynamics, art. 37)."""
    k, w = np.sin(START / 2), np.sqrt(G / LENGTH)
    sn = ellipj(ellipk(k * k) - w * t, k * k)[0]
    phi = 2.0 * np.arcsin(k * sn)
    return LENGTH * np.column_stack([np.sin(phi), np.zeros_like(t), -np.cos(phi)])


@pytest.fixture(scope="module")
def coarse():
    """A run at a tolerance that is far too coarse, and what verify says about it."""
    solution = fmb.simulate(pendulum(), 6.0, samples=121, integrator=fmb.GeneralizedAlpha(rtol=3e-4))
    return solution, fmb.verify(solution)


def test_estimates_are_the_true_error(coarse):
    solution, found = coarse
    error = np.abs(solution["place"] - exact(solution.t)).max() / np.abs(solution["place"]).max()
    assert error > 0.02
    place = next(answer for answer in found.answers if answer.name == "place")
    # IDA at 1e-6 is nearly exact: its distance is the error; a tenth of the tolerance leaves a fifth of it
    np.testing.assert_allclose(place.course["integrator"], error, rtol=0.05)
    assert 0.5 * error < place.course["tolerance"] < 1.2 * error
    assert not place.holds
    assert not found.ok
    assert "do not hold" in found.verdict or "only the greatest values hold" in found.verdict


def test_a_sound_run_holds():
    solution = fmb.simulate(pendulum(), 1.0, samples=41, integrator=fmb.GeneralizedAlpha(rtol=1e-7))
    found = fmb.verify(solution)
    assert found.ok
    assert all(check.holds for check in found.checks)
    names = {check.name for check in found.checks}
    assert names >= {"equations of motion", "accelerations", "energy that nothing explains"}
    assert {f"constraints, {level}" for level in ("position", "velocity", "acceleration")} <= names
    assert found.verdict.startswith("all 2 answers hold within 1 %")
    assert "Compared with: by IDA" in str(found)


def test_kept_and_read_again(coarse, tmp_path):
    path = coarse[1].save(tmp_path / "verification.json")
    assert fmb.Verification.load(path) == coarse[1]
    path.write_text('{"version": 1}')
    with pytest.raises(fmb.DataFileError, match="cannot be read"):
        fmb.Verification.load(path)


def test_energy_that_appears_is_found(coarse):
    """A run whose works do not explain its energy: a drive that is told to have done 1 J of work that it has not."""
    from dataclasses import replace

    phase = coarse[0].phases[0]
    works = phase.works.copy()
    works[60:, 1] += 1.0
    found = fmb.verify(fmb.Solution(phases=(replace(phase, works=works),)))
    energy = next(check for check in found.checks if check.name == "energy that nothing explains")
    # m g (lowest to highest place) = 0.4 * 9.81 * 0.7 * (1 - cos 2) = 3.89 J turned over
    np.testing.assert_allclose(energy.share, 1.0 / 3.89, rtol=0.05)
    assert not energy.holds
    assert "do not rely on this run: energy" in found.verdict
    assert any("no other runs" in note for note in found.notes)


def cantilever(modes: int) -> fmb.Model:
    fe = fem.frame(
        points=np.column_stack([np.linspace(0, 1, 9), np.zeros(9), np.zeros(9)]),
        section=fem.Section.rectangle(0.02, 0.01),
        material=fmb.MATERIALS["steel"],
    )
    data = reduction.reduce(fe, interfaces={"root": [0], "tip": [8]}, modes=4)
    bar = fmb.FloatingBody("bar", data=data, damping=0.02, modes=modes)
    return fmb.Model(
        name="cantilever",
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(markers={"O": (0, 0, 0)}), bar],
        joints=[fmb.Fixed("clamp", markers=("ground.O", "bar.root"))],
        sensors=[fmb.Deflection("bow", marker="bar.tip")],
    )


def test_missing_modes_are_found():
    """Two modes of ten cannot bend the bar under its weight as the others do; all ten can, w = q l^4 / 8 EI."""
    few = fmb.verify(fmb.simulate(cantilever(8), 0.02, samples=11))
    assert any("10 for 8" in text for text in few.runs), few.runs
    assert few.answers[0].course["modes"] > 0.01
    assert any("meshes behind the reduced data of bar" in note for note in few.notes)


def test_mesh_of_cables_is_varied():
    rope = fmb.AncfCable(
        "rope",
        points=((0, 0, 0), (1, 0, 0)),
        elements=1,
        section=fem.Section.solid_circle(0.01),
        material=fmb.Material(young=1e7, poisson=0.3, density=1000.0),
    )
    model = fmb.Model(
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(markers={"A": (0, 0, 0)}), rope],
        joints=[fmb.Spherical("A", markers=("ground.A", "rope.start"))],
        sensors=[fmb.Position("tip", marker="rope.end")],
    )
    found = fmb.verify(fmb.simulate(model, 0.3, samples=16))
    assert any("rope 2 for 1 elements" in text for text in found.runs)
    assert found.answers[0].course["mesh"] > 0.01 > found.answers[0].course["tolerance"]


def test_events_and_windows():
    """A strut that is released: runs with other steps meet the event at other times, and answers are still compared."""
    bodies = [fmb.Ground(markers={"O": (0, 0, 0)}), fmb.PointMass("bob", mass=1.0, at=(1.0, 0, 0))]
    spring = fmb.SpringDamper("spring", markers=("ground.O", "bob.center"), stiffness=30.0, length=0.5)
    model = fmb.Model(
        gravity=(0, 0, -G),
        bodies=bodies,
        forces=[spring],
        sensors=[
            fmb.Position("place", marker="bob.center"),
            fmb.ForceOf("pull", force="spring"),
            fmb.Distance("length", markers=("ground.O", "bob.center")),
        ],
        events=[fmb.Event("tears", sensor="length", below=0.8, then=fmb.Release("spring"))],
    )
    solution = fmb.simulate(model, 0.6, samples=61)
    assert len(solution.phases) == 2
    found = fmb.verify(solution, window=(0.1, 0.4))
    assert found.ok, str(found)
    assert "by IDA, t = 0.1 to 0.4 s" in found.runs
    assert found.answers[1].largest > 10.0


def test_equilibrium_has_no_integrator():
    """One metre of rope: its iterations are no equilibria, its last sample is one."""
    rope = fmb.AncfCable(
        "rope",
        points=((0, 0, 0), (1, 0, 0)),
        elements=2,
        section=fem.Section.solid_circle(0.01),
        material=fmb.Material(young=1e8, poisson=0.3, density=1000.0),
    )
    ends = [fmb.Spherical(name, markers=(f"ground.{name}", f"rope.{name}")) for name in ("start", "end")]
    ground = fmb.Ground(markers={"start": (0, 0, 0), "end": (0.99, 0, 0)})
    solution = fmb.statics(fmb.Model(gravity=(0, 0, -G), bodies=[ground, rope], joints=ends))
    found = fmb.verify(solution)
    assert found.ok
    assert found.answers == ()
    assert "the equations hold" in found.verdict


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"within": 1.5}, "verify: within = 1.5. Expected: a share between 0 and 1"),
        ({"window": (0.5, 0.2)}, "verify: window = .0.5, 0.2.. Expected: two times from 0 to 6 s"),
        ({"integrator": "IDA"}, "verify: integrator = 'IDA'"),
    ],
)
def test_messages(coarse, arguments, message):
    with pytest.raises(fmb.ModelError, match=message):
        fmb.verify(coarse[0], **arguments)


def test_what_is_no_solution_or_has_no_model(coarse):
    from dataclasses import replace

    with pytest.raises(fmb.ModelError, match="an object of the class Model"):
        fmb.verify(pendulum())
    bare = fmb.Solution(phases=(replace(coarse[0].phases[0], model=None),))
    with pytest.raises(fmb.ModelError, match="the model of the solution is not known"):
        fmb.verify(bare)


@pytest.mark.parametrize("joint", [fmb.Spherical, fmb.Fixed], ids=["hangs", "is held"])
def test_a_model_at_rest_is_compared_with_its_loads(joint):
    """All that moves is rounding: compared with itself, everything would fail. Under a wrong load it still fails."""
    axes, place, lever = (0.3, 0.4, 0.5), np.array([0.1, 0.2, 0.3]), np.array([0.0, 0.0, 0.7])
    own = Rotation.from_rotvec(axes).inv().apply(lever)
    body = fmb.RigidBody("b", mass=1.0, inertia=(1, 2, 3), at=tuple(place), rotation=axes, markers={"p": tuple(own)})
    model = fmb.Model(
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(markers={"q": fmb.Pose(tuple(place + lever), axes)}), body],
        joints=[joint("j", markers=("ground.q", "b.p"))],
        sensors=[fmb.Position("place", marker="b.center")],
    )
    solution = fmb.simulate(model, 1.0, samples=6)
    assert 0.0 < max(np.abs(solution.phases[0].u).max(), np.abs(solution.phases[0].a).max()) < 1e-12
    found = fmb.verify(solution)
    assert all(check.share <= check.limit for check in found.checks), found
    pushed = replace(solution.phases[0], a=solution.phases[0].a + 1e-3)
    wrong = fmb.verify(replace(solution, phases=(pushed,)))
    assert [check.name for check in wrong.checks if check.share > check.limit], wrong
