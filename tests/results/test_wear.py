"""Wear by Archard's law, V = k F s, and the fields of a contact in files for ParaView."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import FlexmbError

K = 1e-13
LAW = fmb.ElasticFoundation(modulus=1e8, thickness=0.01, damping=1.0, friction=0.3, transition=1e-3)


def test_block_slides_to_rest():
    """All kinetic energy goes into friction: the way is v^2 / (2 mu g), the volume k m v^2 / (2 mu)."""
    m, v = 5.0, 0.5
    depth = m * 9.81 / (0.01 * 1e10)
    size = (0.1, 0.1, 0.05)
    block = fmb.RigidBody.box("block", density=m / 5e-4, size=size, at=(0, 0, 0.025 - depth), velocity=(v, 0, 0))
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"floor": (0, 0, 0)}), block],
        surfaces=[
            fmb.Surface("floor", marker="ground.floor", shape=fmb.Plane()),
            fmb.Surface("sides", marker="block.center", shape=fmb.Cuboid(size=(0.1, 0.1, 0.05)), spacing=0.01),
        ],
        forces=[fmb.SurfaceContact("touch", surfaces=("floor", "sides"), law=LAW)],
        sensors=[fmb.Position("at", marker="block.center")],
    )
    run = fmb.simulate(model, 0.25, integrator=fmb.GeneralizedAlpha(rho_inf=0.3, rtol=1e-5), samples=501)
    worn = fmb.wear(run, "touch", K)
    expected = K * m * v**2 / (2 * 0.3)
    assert worn.volume[-1] == pytest.approx(expected, rel=0.01)
    assert np.all(np.diff(worn.volume) >= 0.0)
    assert run["at"][-1, 0] == pytest.approx(v**2 / (2 * 0.3 * 9.81), rel=0.01)
    below = worn.places[:, 2] < -0.0249
    assert worn.depth[below].min() > 0.0
    assert not np.any(worn.depth[~below])
    assert worn.depth[below].mean() * 0.01 == pytest.approx(worn.volume[-1], rel=1e-9)


@pytest.fixture(scope="module")
def pin_on_disc():
    """A pin of 10 x 10 mm, pressed with 50 N on a disc 50 mm from its axis, which turns twice."""
    disc = fmb.RigidBody.cylinder("disc", density=7850.0, radius=0.06, length=0.01, at=(0, 0, -0.005))
    pin = fmb.RigidBody.box("pin", density=7850.0, size=(0.01, 0.01, 0.02), at=(0.05, 0, 0.01 - 5e-5))
    model = fmb.Model(
        gravity=(0, 0, 0),
        bodies=[fmb.Ground(markers={"axis": (0, 0, -0.005), "guide": (0.05, 0, 0)}), disc, pin],
        joints=[
            fmb.Revolute("turn", markers=("ground.axis", "disc.center")),
            fmb.Drive("motor", joint="turn", angle=fmb.expression("w*t", w=20 * np.pi)),
            fmb.Prismatic("guide", markers=("ground.guide", "pin.center")),
        ],
        surfaces=[
            fmb.Surface("disc", marker="disc.center", shape=fmb.Cylinder(radius=0.06, length=0.01)),
            fmb.Surface("pin", marker="pin.center", shape=fmb.Cuboid(size=(0.01, 0.01, 0.02)), spacing=0.002),
        ],
        forces=[
            fmb.SurfaceContact("touch", surfaces=("disc", "pin"), law=LAW),
            fmb.PointLoad("press", marker="pin.center", force=(0, 0, -50.0)),
        ],
    )
    return fmb.simulate(model, 0.2, integrator=fmb.GeneralizedAlpha(rho_inf=0.3, rtol=1e-5), samples=41)


def test_pin_on_disc(pin_on_disc):
    """Each point of the pin loses k p 2 pi r n, and the pin k F 2 pi R n with the mean radius R."""
    worn = fmb.wear(pin_on_disc, "touch", K)
    below = worn.depth > 0.0
    r = np.hypot(worn.places[below, 0] + 0.05, worn.places[below, 1])
    assert below.sum() == 25
    np.testing.assert_allclose(worn.depth[below], K * 50.0 / 1e-4 * 2 * np.pi * r * 2, rtol=2e-3)
    assert worn.volume[-1] == pytest.approx(K * 50.0 * 2 * np.pi * r.mean() * 2, rel=2e-3)
    assert worn.volume[20] == pytest.approx(0.5 * worn.volume[-1], rel=2e-3)


def test_fields_in_a_file(pin_on_disc, tmp_path):
    """The pressure over the squares is the force, the slip that of the circle, and the way what wear is made of."""
    import pyvista

    fmb.write_vtk(pin_on_disc, tmp_path / "run.pvd", every=20)
    reader = pyvista.get_reader(tmp_path / "run.pvd")
    reader.set_active_time_value(0.2)
    assert sum("pressure" in block.point_data for block in reader.read()) == 1
    grid = pyvista.read(tmp_path / "run" / "touch_2.vtu")
    area = grid.compute_cell_sizes()["Area"]
    pressure, slip, way = (grid[name][::4] for name in ("pressure", "slip", "pressure_times_way"))
    middle = grid.points.reshape(-1, 4, 3).mean(axis=1)[:, :2]
    assert len(pressure) == 25
    assert area @ pressure == pytest.approx(50.0, rel=1e-3)
    assert slip.mean() == pytest.approx(20 * np.pi * np.hypot(*middle.T).mean(), rel=1e-3)
    assert K * (area @ way) == pytest.approx(fmb.wear(pin_on_disc, "touch", K).volume[-1], rel=1e-5)
    np.testing.assert_allclose(grid.points[:, 2].mean(), 0.0, atol=1e-4)


def test_fields_in_hdf5(pin_on_disc, tmp_path):
    import h5py

    fmb.write_vtk(pin_on_disc, tmp_path / "run.vtkhdf", every=20)
    with h5py.File(tmp_path / "run_touch.vtkhdf") as file:
        fields = {name: file[f"VTKHDF/PointData/{name}"][-100:] for name in ("pressure", "slip", "pressure_times_way")}
    assert fields["pressure"].mean() * 1e-4 == pytest.approx(50.0, rel=1e-3)
    assert fields["slip"].min() > 2.8
    assert K * fields["pressure_times_way"].mean() == pytest.approx(K * 5e5 * 4 * np.pi * 0.05, rel=5e-3)


def test_picture(pin_on_disc, tmp_path):
    """Where it is pressed a picture of the contact is not the grey of the bodies."""
    import matplotlib.image

    fmb.view.render(
        pin_on_disc, tmp_path / "pin.png", hide=["pin_surface", "joints"], size=(480, 320), camera=(0, 0, 1)
    )
    colours = matplotlib.image.imread(tmp_path / "pin.png")[..., :3]
    above = colours[:200]  # the colour bar is below
    assert np.mean(above[..., 0] - above[..., 2] > 0.25) > 5e-4  # the yellow of the highest pressure


@pytest.mark.parametrize(
    ("force", "coefficient", "message"),
    [("rub", K, "no force 'rub'.*touch"), ("press", K, "a PointLoad"), ("touch", -1.0, "coefficient = -1.0")],
)
def test_refused(pin_on_disc, force, coefficient, message):
    with pytest.raises(FlexmbError, match=message):
        fmb.wear(pin_on_disc, force, coefficient)
