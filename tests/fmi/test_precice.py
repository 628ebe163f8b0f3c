"""A model coupled through the interface of preCICE 3: a stand-in for the library, with another oscillator behind it."""

import numpy as np
import pytest
from scipy.linalg import expm

import flexmb as fmb

M1, M2, K1, K12, K2 = 1.0, 2.0, 30.0, 20.0, 10.0


class StandIn:
    """Answers as ``precice.Participant`` of version 3 does, for one mesh with one vertex.

    Behind it is a second mass, integrated exactly by the matrix exponential; the spring between both is there. Time
    windows are of `window`; with `iterations` each is repeated (implicit coupling). Data of a window are interpolated
    linearly in time between its ends.
    """

    def __init__(self, window, end, iterations=1, dimensions=3):
        self.window, self.end, self.iterations, self.dimensions = window, end, iterations, dimensions
        self.t, self.done, self.left, self.log = 0.0, 0, window, []
        self.z = self.begin = np.array([0.0, 0.0])
        self.moved = [0.1, 0.1]  # displacement at the begin and the end of the window
        self.force = [0.0, 0.0]
        self.fresh = True

    def get_mesh_dimensions(self, mesh):
        assert mesh == "Solid"
        return self.dimensions

    def set_mesh_vertices(self, mesh, places):
        assert places.shape == (1, self.dimensions)
        return np.array([0])

    def requires_initial_data(self):
        return True

    def write_data(self, mesh, data, vertices, values):
        assert (mesh, data, list(vertices)) == ("Solid", "Displacement", [0])
        assert values.shape == (1, self.dimensions)
        self.moved[1] = float(values[0, 0])
        if self.log == []:
            self.moved[0] = self.moved[1]

    def initialize(self):
        self.log.append("initialize")
        self.force = [K12 * (self.z[0] - self.moved[0])] * 2

    def is_coupling_ongoing(self):
        return self.t < self.end - 1e-12

    def requires_writing_checkpoint(self):
        fresh, self.fresh = self.fresh, False
        return fresh and self.iterations > 1

    def get_max_time_step_size(self):
        return self.left

    def read_data(self, mesh, data, vertices, after):
        assert 0.0 <= after <= self.left
        share = (self.window - self.left + after) / self.window
        value = np.zeros((1, self.dimensions))
        value[0, 0] = (1.0 - share) * self.force[0] + share * self.force[1]
        return value

    def advance(self, h):
        self.left -= h
        if self.left > 1e-12:
            return
        # the other mass with the displacement linear over the window: x'' = -(K2 + K12)/M2 x + K12/M2 (a + b t)
        A = np.zeros((4, 4))
        A[0, 1] = A[2, 3] = 1.0
        A[1, 0], A[1, 2] = -(K2 + K12) / M2, K12 / M2
        slope = (self.moved[1] - self.moved[0]) / self.window
        self.z = (expm(A * self.window) @ [*self.begin, self.moved[0], slope])[:2]
        self.force[1] = K12 * (self.z[0] - self.moved[1])
        self.done, self.left = self.done + 1, self.window
        if self.done == self.iterations:
            self.done, self.t, self.begin, self.fresh = 0, self.t + self.window, self.z, True
            self.moved[0] = self.moved[1]
            self.force = [self.force[1]] * 2
            self.again = False
        else:
            self.again = True

    def requires_reading_checkpoint(self):
        return self.iterations > 1 and self.left == self.window and self.again

    def finalize(self):
        self.log.append("finalize")


def solid(**more) -> fmb.Model:
    return fmb.Model(
        bodies=[fmb.Ground(markers={"wall": (-1, 0, 0)}), fmb.PointMass("mass", mass=M1, at=(0.1, 0, 0))],
        forces=[fmb.SpringDamper("spring", markers=("ground.wall", "mass.center"), stiffness=K1, length=1.0)],
        sensors=[fmb.Position("place", marker="mass.center")],
        **more,
    )


MESH = fmb.fmi.CouplingMesh("Solid", ["mass.center"], writes={"Displacement": "position"}, reads={"Force": "force"})


def exact(t):
    A = np.zeros((4, 4))
    A[0, 1] = A[2, 3] = 1.0
    A[1, 0], A[1, 2], A[3, 0], A[3, 2] = -(K1 + K12) / M1, K12 / M1, K12 / M2, -(K2 + K12) / M2
    return (expm(A * t) @ (0.1, 0, 0, 0))[0]


def error(window, iterations, **more):
    other = StandIn(window, 1.0, iterations)
    run = fmb.fmi.couple(solid(), other, MESH, integrator=fmb.Explicit(), **more)
    assert other.log == ["initialize", "finalize"]
    assert run.t[-1] == pytest.approx(1.0)
    return abs(run["place"][-1, 0] - exact(1.0))


def test_implicit_coupling_goes_back_exactly_and_is_of_second_order():
    """Two masses and three springs, one mass on either side, against the matrix exponential of both."""
    coarse, fine = error(0.02, 12), error(0.01, 12)
    assert fine < 2e-4
    assert coarse / fine == pytest.approx(4.0, abs=0.4)


def test_explicit_coupling_is_of_first_order():
    coarse, fine = error(0.01, 1), error(0.005, 1)
    assert fine < 5e-3
    assert coarse / fine == pytest.approx(2.0, abs=0.4)


@pytest.mark.slow
def test_steps_within_a_window():
    """Four exchanges in a window, each with the force at its own time: nearly as good as a short window."""
    assert error(0.02, 12, step=0.005) < error(0.02, 12)


def test_two_dimensions_and_displacements():
    mesh = fmb.fmi.CouplingMesh(
        "Solid", ["mass.center"], writes={"Displacement": "displacement"}, reads={"Force": "force"}
    )
    other = StandIn(0.05, 0.1, dimensions=2)
    run = fmb.fmi.couple(solid(), other, mesh, integrator=fmb.Explicit())
    assert other.moved[1] == pytest.approx(run["place"][-1, 0] - 0.1, abs=1e-12)


def test_what_is_wrong_is_said():
    with pytest.raises(fmb.ModelError, match=r"'displacment'.*Did you mean 'displacement'"):
        fmb.fmi.CouplingMesh("Solid", ["mass.center"], writes={"D": "displacment"})
    with pytest.raises(fmb.ModelError, match="different names"):
        fmb.fmi.CouplingMesh("Solid", [])
    mesh = fmb.fmi.CouplingMesh("Solid", ["mass.centre"], reads={"Force": "force"})
    with pytest.raises(fmb.ModelError, match=r"'mass\.centre' does not exist"):
        fmb.fmi.couple(solid(), StandIn(0.1, 1.0), mesh)
    with pytest.raises(fmb.ModelError, match="without config"):
        fmb.fmi.couple(solid(), "Solid", MESH)
    with pytest.raises(fmb.ModelError, match="step"):
        fmb.fmi.couple(solid(), StandIn(0.1, 1.0), MESH, step=-1.0)


def test_a_library_that_is_not_there_is_said():
    pytest.importorskip("flexmb")
    try:
        import precice  # noqa: F401
    except ImportError:
        with pytest.raises(fmb.DataFileError, match="pyprecice"):
            fmb.fmi.couple(solid(), "Solid", MESH, config="precice-config.xml")


def test_calls_are_those_of_the_python_bindings(monkeypatch):
    """preCICE 3, python-bindings, cyprecice.pyx: names and order of arguments as they are documented there."""
    import sys
    from types import SimpleNamespace

    inner = StandIn(0.1, 0.3)

    class Participant:
        def __init__(self, solver_name, configuration_file_name, solver_process_index, solver_process_size):
            given = solver_name, configuration_file_name, solver_process_index, solver_process_size
            assert given == ("Solid", "precice-config.xml", 0, 1)

        def set_mesh_vertices(self, mesh_name, positions):
            assert mesh_name == "Solid"
            assert isinstance(positions, np.ndarray)
            return np.array([0], np.int32)

        def write_data(self, mesh_name, data_name, vertex_ids, values):
            assert isinstance(values, np.ndarray)
            assert len(vertex_ids) == len(values)
            inner.write_data(mesh_name, data_name, vertex_ids, values)

        def read_data(self, mesh_name, data_name, vertex_ids, relative_read_time):
            assert 0.0 <= relative_read_time <= self.get_max_time_step_size()
            return inner.read_data(mesh_name, data_name, vertex_ids, relative_read_time)

        def advance(self, computed_timestep_length):
            inner.advance(computed_timestep_length)

        def __getattr__(self, name):
            return getattr(inner, name)

    monkeypatch.setitem(sys.modules, "precice", SimpleNamespace(Participant=Participant))
    run = fmb.fmi.couple(solid(), "Solid", MESH, config="precice-config.xml")
    assert run.t[-1] == pytest.approx(0.3)
    assert inner.log == ["initialize", "finalize"]


def test_a_model_that_fails_finalizes_and_keeps_results():
    class Broken(StandIn):
        def read_data(self, mesh, data, vertices, after):
            return super().read_data(mesh, data, vertices, after) * (np.nan if self.t > 0.35 else 1.0)

    other = Broken(0.1, 1.0)
    with pytest.raises(fmb.IntegrationError, match=r"Force.*not finite") as raised:
        fmb.fmi.couple(solid(), other, MESH)
    assert other.log[-1] == "finalize"
    assert raised.value.solution.t[-1] == pytest.approx(0.4)


def test_an_interrupt_finalizes():
    """The others would wait for a participant that is gone."""

    class Interrupted(StandIn):
        def read_data(self, mesh, data, vertices, after):
            if self.t > 0.35:
                raise KeyboardInterrupt
            return super().read_data(mesh, data, vertices, after)

    other = Interrupted(0.1, 1.0)
    with pytest.raises(KeyboardInterrupt):
        fmb.fmi.couple(solid(), other, MESH)
    assert other.log[-1] == "finalize"
