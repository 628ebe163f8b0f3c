"""Pictures: the right values on the right points, everything in the frame, and messages where nothing can be drawn."""

import sys

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import FlexmbError
from flexmb.io.scene import Scene
from flexmb.view import graphics, overlay, render, window
from flexmb.view.interactive import opened
from flexmb.view.labels import places, without_overlap
from flexmb.view.pictures import hidden_parts, require_hidden
from flexmb.view.stage import CONTACT_LABEL, ELASTIC_LABEL, VIEW_ANGLE, Look, Stage, bar, camera_position, framed_points
from flexmb.view.viewpoint import best_direction, viewpoint


@pytest.mark.render
def test_values_sit_on_their_points(solution):
    """Surfaces of quadratic cells: each point shown is a node with that node's stress, also after a move."""
    scene = Scene(solution)
    stage = Stage(scene, (64, 64), 1e6)
    stage.add_state(1)
    for frame in (1, 3):
        stage.move_to(frame)
        assert "block" in {part.name for part, *_ in stage._drawn}
        for part, surface, ids, _ in stage._drawn:
            snapshot = scene.snapshot(part, frame)
            np.testing.assert_allclose(surface.points, snapshot.points[ids], rtol=0, atol=1e-6)
            if part.name == "block":
                np.testing.assert_allclose(surface.point_data[ELASTIC_LABEL], 1e-6 * snapshot.von_mises[ids], rtol=1e-6)
    stage.close()


@pytest.mark.render
def test_elastic_displacement_can_be_magnified(solution):
    scene = Scene(solution)
    stage = Stage(scene, (64, 64), 0.0, scale=50.0)
    stage.add_state(4, Look())
    part, surface, ids, _ = next(entry for entry in stage._drawn if entry[0].name == "block")
    plain = scene.snapshot(part, 4)
    np.testing.assert_allclose(surface.points, (plain.points + 49.0 * plain.displacement)[ids], rtol=0, atol=1e-5)
    stage.close()


@pytest.mark.render
def test_beams_without_a_figure_move():
    """A reduced beam of constants is drawn as lines, which have no normals; a page of it, and its film, ended there."""
    section = fem.Section.values(area=1e-3, inertia_y=1e-7, inertia_z=2e-7, torsion=1e-7)
    fe = fem.frame([(0, 0, 0), (0.5, 0, 0), (1, 0, 0)], section=section, material=fmb.MATERIALS["steel"])
    data = reduction.reduce(fe, {"root": [0], "tip": [2]}, modes=2)
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("beam", data=data)],
        joints=[fmb.Revolute("pin", markers=("ground.origin", "beam.root"))],
        gravity=(0, -9.81, 0),
    )
    solution = fmb.simulate(model, 0.2, samples=3)
    scene = Scene(solution)
    stage = Stage(scene, (64, 64), 0.0)
    stage.add_state(0)
    stage.move_to(2)
    moved = {part.name: (surface, ids, part) for part, surface, ids, _ in stage._drawn}
    surface, ids, part = moved["beam"]
    assert surface.n_lines == surface.n_cells > 0
    np.testing.assert_allclose(surface.points, scene.points(part, 2, ids), atol=1e-6)
    assert np.ptp(surface.points[:, 1]) > 0.05
    stage.close()


@pytest.mark.render
def test_still_picture(solution, tmp_path):
    import pyvista

    path = render(solution, tmp_path / "out" / "spin.png", times=0.04, size=(320, 180))
    image = pyvista.read(path).point_data.active_scalars
    assert image.shape[0] == 320 * 180
    assert len(np.unique(image, axis=0)) > 500


@pytest.mark.render
def test_states_over_one_another(solution, tmp_path):
    import pyvista

    one = render(solution, tmp_path / "one.png", size=(320, 180), camera=(0, 0, 1))
    several = overlay(solution, tmp_path / "several.png", times=(0.0, 0.04, 0.08), size=(320, 180), camera=(0, 0, 1))
    a, b = (pyvista.read(path).point_data.active_scalars.astype(float) for path in (one, several))
    assert np.abs(a - b).max() > 30


@pytest.mark.render
def test_hidden_parts_and_labels(tmp_path):
    """What is hidden is not in the picture, a text is; unknown names and markers are named."""
    import pyvista

    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody.box(
                "rod", size=(1, 0.1, 0.1), density=100.0, at=(0.5, 0, 0), markers={"a": (-0.5, 0, 0), "b": (0.5, 0, 0)}
            ),
        ],
        joints=[fmb.Revolute("pin", markers=("ground.origin", "rod.a"))],
    )
    solution = fmb.simulate(model, 0.01, samples=2)

    def pixels(name, **fields):
        path = render(solution, tmp_path / f"{name}.png", size=(320, 180), camera=(0, 0, 1), **fields)
        return pyvista.read(path).point_data.active_scalars.astype(float)

    plain = pixels("plain")
    assert np.abs(pixels("hidden", hide=("joints", "supports")) - plain).max() > 30
    assert np.abs(pixels("label", labels={"tip": "rod.b"}) - plain).max() > 30
    with pytest.raises(FlexmbError, match=r"hide names 'joint'.*Did you mean 'joints'"):
        render(solution, tmp_path / "x.png", hide=("joint",))
    with pytest.raises(FlexmbError, match="everything is hidden"):
        render(solution, tmp_path / "x.png", hide=[part.name for part in Scene(solution).parts])
    assert np.abs(pixels("body", labels={"bar": "rod"}) - plain).max() > 30
    np.testing.assert_array_equal(pixels("all", labels="bodies"), pixels("named", labels={"rod": "rod"}))
    with pytest.raises(FlexmbError, match=r"label 'tip': .*nothing"):
        render(solution, tmp_path / "x.png", labels={"tip": "nothing.tip"})
    with pytest.raises(FlexmbError, match=r"label 'tip': there is no body 'rood'.*Did you mean 'rod'"):
        render(solution, tmp_path / "x.png", labels={"tip": "rood"})


def test_names_of_bodies_do_not_cover_one_another():
    """Two texts of five letters of 10 pixels: 38 pixels wide and 13 high, from their lower left corners. Given ones are
    moved by lines of 16 pixels, up first, and stay within the picture."""
    texts, picture = ["large", "small", "third"], (320, 180)

    def placed(seen, given=0):
        found = without_overlap(texts, np.array(seen, float), 10.0, picture, given)
        return {text: tuple(place) for text, place in found.items()}

    assert placed([[0, 0], [37, 12], [39, 0]]) == {"large": (0, 0), "third": (39, 0)}
    assert placed([[0, 0], [0, 14], [39, 0]]) == {"large": (0, 0), "small": (0, 14), "third": (39, 0)}
    assert placed([[0, 0]] * 3, given=2) == {"large": (0, 0), "small": (0, 16)}
    assert placed([[0, 90]] * 3, given=3) == {"large": (0, 90), "small": (0, 106), "third": (0, 74)}
    assert placed([[300, 175]] * 3, given=3) == {"large": (282, 167), "small": (282, 151), "third": (282, 135)}


@pytest.mark.render
def test_labels_at_one_place_are_all_drawn(tmp_path):
    """Six texts at one point stand above one another: each of them changes the picture."""
    import pyvista

    bar = fmb.RigidBody("rod", mass=1.0, inertia=(1.0, 1.0, 1.0), markers={"b": (0.5, 0, 0)})
    solution = fmb.simulate(fmb.Model(bodies=[fmb.Ground(), bar]), 0.01, samples=2)
    before = None
    for count in range(7):
        path = tmp_path / f"{count}.png"
        labels = {f"text {k}": "rod.b" for k in range(count)}
        render(solution, path, size=(640, 360), camera=(0, 0, 1), labels=labels)
        picture = pyvista.read(path).point_data.active_scalars.astype(float)
        if before is not None:
            assert (np.abs(picture - before).max(axis=1) > 100).sum() > 50
        before = picture


@pytest.mark.render
def test_labels_are_where_the_bodies_are(solution):
    """The place in the picture is that of pyvista's own projection; every drawn body is named, the largest first."""
    scene = Scene(solution)
    stage = Stage(scene, (320, 180), 0.0)
    try:
        stage.add_state(0)
        stage.look_from((0.3, -1.0, 0.4), (0.0, 0.0, 1.0))
        found, given = places(scene, "bodies", 0)
        assert given == 0
        drawn = [part for part in scene.parts if part.look in ("flexible", "rigid")]
        assert set(found) == {part.name for part in drawn}
        points = np.array(list(found.values()))
        renderer, seen = stage.plotter.renderer, []
        for point in points:
            renderer.SetWorldPoint([*point, 1.0])
            renderer.WorldToDisplay()
            seen.append(renderer.GetDisplayPoint()[:2])
        np.testing.assert_allclose(stage._seen(points), seen, atol=1.0)
    finally:
        stage.close()


@pytest.mark.render
def test_animation_has_every_sample(solution, tmp_path):
    import imageio.v2 as imageio

    path = render(solution, tmp_path / "spin.gif", size=(160, 90))
    frames = imageio.mimread(path)
    assert len(frames) == 5
    assert np.abs(frames[0].astype(float) - frames[2]).max() > 30


@pytest.mark.render
def test_the_camera_of_an_animation_sees_the_whole_motion(solution):
    """The rod makes half a turn: placed by the first frame alone, the camera would lose it."""
    scene = Scene(solution)
    stage = Stage(scene, (320, 180), 0.0)
    stage.add_state(0)
    outside = []
    for frames in ((), range(5)):
        stage.look_from((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), list(frames))
        eye, focus, up = (np.array(x) for x in stage.plotter.camera_position)
        ahead = (focus - eye) / np.linalg.norm(focus - eye)
        right = np.cross(ahead, up)
        axes = np.stack([right, np.cross(right, ahead), ahead], 1)
        slope = np.tan(np.radians(VIEW_ANGLE / 2))
        seen = np.vstack([(scene.snapshot(part, k).points - eye) @ axes for part in scene.parts for k in range(5)])
        outside.append(int(np.sum(np.abs(seen[:, 0] / seen[:, 2]) > slope * 320 / 180)))
        outside[-1] += int(np.sum(np.abs(seen[:, 1] / seen[:, 2]) > slope))
    assert outside[0] > 0
    assert outside[1] == 0
    stage.close()


def test_few_points_stand_for_all(solution):
    """The box around the outer points is that around all points, at every sample."""
    scene = Scene(solution)
    every = np.vstack([scene.snapshot(part, k).points for part in scene.parts for k in range(5)])
    outer = framed_points(scene, list(range(5)))
    assert len(outer) < len(every)
    size = np.ptp(every, axis=0).max()
    np.testing.assert_allclose(outer.min(axis=0), every.min(axis=0), atol=0.01 * size)
    np.testing.assert_allclose(outer.max(axis=0), every.max(axis=0), atol=0.01 * size)


@pytest.mark.render
def test_the_window_moves_through_time(solution):
    """Slider, keys and clock, without a screen: the points shown are those of the sample."""
    stage, player = opened(solution, None, (320, 180), 1.0, 0.4, shown=False)
    times = stage.scene.times

    def shown():
        part, surface, ids, _ = stage._drawn[0]
        return [
            k for k in range(5) if np.allclose(surface.points, stage.scene.snapshot(part, k).points[ids], atol=1e-6)
        ]

    assert shown() == [0]
    player.to_time(0.041)
    assert shown() == [2]
    assert player.slider.GetRepresentation().GetValue() == times[2]
    player.to_frame(99)
    assert shown() == [4]
    player.start_or_stop()
    for _ in range(4):  # 0.4 s for the whole motion at 25 pictures per second: four of them reach sample 2 of 4
        player.tick()
    assert player.playing
    assert shown() == [2]
    for _ in range(7):
        player.tick()
    assert not player.playing
    assert shown() == [4]
    stage.close()


def test_no_screen(solution, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(FlexmbError, match=r"Window: there is no screen .*flexmb render RUN -o motion\.gif"):
        window(solution)


@pytest.mark.render
def test_mp4(solution, tmp_path):
    pytest.importorskip("imageio_ffmpeg")
    path = render(solution, tmp_path / "spin.mp4", size=(160, 90))
    assert path.read_bytes()[4:8] == b"ftyp"


def test_everything_is_in_the_frame(rng):
    """Projected by hand: no point leaves the picture or falls into the room for the colour scale."""
    slope, aspect, room = np.tan(np.radians(VIEW_ANGLE / 2)), 16 / 9, 0.22
    for camera in ((0.3, -1.0, 0.3), (1.0, -2.0, 0.5), (0.0, 0.0, 1.0)):
        points = rng.normal(size=(40, 3)) * (3.0, 0.4, 1.0) + (5.0, 1.0, -2.0)
        eye, focus, up = (np.array(x) for x in camera_position(points, camera, (0, 0, 1), aspect, room))
        ahead = (focus - eye) / np.linalg.norm(focus - eye)
        right = np.cross(ahead, up)
        right /= np.linalg.norm(right)
        seen = (points - eye) @ np.stack([right, np.cross(right, ahead), ahead], 1)
        x, y = seen[:, 0] / (seen[:, 2] * slope * aspect), seen[:, 1] / (seen[:, 2] * slope)
        assert np.abs(x).max() <= 1.0
        assert y.max() <= 1.0
        assert y.min() >= -1.0 + 1.5 * room
        assert max(np.abs(x).max(), (y.max() - y.min()) / 2 / (1 - room)) > 0.5


def moving(rng, size, motion, samples=5):
    """Return points in a box that move along a line, the more the further aft (x) they are."""
    points = rng.uniform(-0.5, 0.5, size=(60, 3)) * size
    far = (points[:, :1] - points[:, 0].min()) / max(np.ptp(points[:, 0]), 1e-9)
    return points + np.linspace(0.0, 1.0, samples)[:, None, None] * far * np.array(motion)


def test_planar_mechanisms_show_their_plane(rng):
    """Seen across their plane, a little from above and from the side; at rest too. A flat one is seen from
    above, and where y is up with x to the right."""
    for motion in ((0.3, 0.0, 0.2), (0.0, 0.0, 0.0)):
        direction = best_direction(moving(rng, (2.0, 0.02, 1.0), motion), (0, 0, 1))
        assert -direction[1] > 0.85
        assert 0.1 < direction[2] < 0.5
        assert abs(direction[0]) > 0.1
    flat = best_direction(moving(rng, (2.0, 1.0, 0.02), (0.3, 0.2, 0.0)), (0, 0, 1))
    assert flat[2] > 0.4
    gravity_along_y = best_direction(moving(rng, (2.0, 1.0, 0.02), (0.3, 0.2, 0.0)), (0, 1, 0))
    assert gravity_along_y[2] > 0.85


def test_a_long_wing_is_seen_from_the_side_of_its_flaps(rng):
    """Neither along the span, where stations hide each other, nor along the motion; from behind, where the flaps go."""
    direction = best_direction(moving(rng, (3.0, 18.0, 0.5), (1.5, 0.0, -0.8)), (0, 0, 1))
    assert direction[0] > 0.3
    assert 0.3 < abs(direction[1]) < 0.9
    assert 0.2 < direction[2] < 0.8
    forward = best_direction(moving(rng, (-3.0, 18.0, 0.5), (1.5, 0.0, -0.8)) * (-1, 1, 1), (0, 0, 1))
    assert forward[0] < -0.3


@pytest.mark.render
def test_the_view_is_that_of_the_scene(solution):
    """Pictures, windows and ParaView scripts take it where no camera is given."""
    scene = Scene(solution)
    stage = Stage(scene, (320, 180), 0.0)
    stage.add_state(0)
    stage.look_from(None, (0.0, 0.0, 1.0))
    eye, focus, _ = (np.array(x) for x in stage.plotter.camera_position)
    np.testing.assert_allclose((eye - focus) / np.linalg.norm(eye - focus), viewpoint(scene, (0, 0, 1)), atol=1e-6)
    stage.close()


def test_messages(solution, tmp_path, monkeypatch):
    with pytest.raises(FlexmbError, match=r"the ending '.bmp'.*\.png, \.jpg"):
        render(solution, tmp_path / "x.bmp")
    with pytest.raises(FlexmbError, match=r"the ending '.gif'"):
        overlay(solution, tmp_path / "x.gif", times=(0, 1))
    monkeypatch.setattr(graphics, "_outcome", lambda: -11)
    with pytest.raises(FlexmbError, match=r"trial picture ended with code -11.*libegl1.*mesa-libEGL"):
        render(solution, tmp_path / "x.png")
    monkeypatch.setitem(sys.modules, "imageio.v2", None)
    with pytest.raises(FlexmbError, match=r"the package imageio.* is not installed.*pip install"):
        render(solution, tmp_path / "x.gif")


@pytest.fixture(scope="module")
def box_on_floor():
    """A box that rests on a floor, with the areas of its contact."""
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), fmb.RigidBody.box("box", density=1700.0, size=(0.2, 0.1, 0.06), at=(0, 0, 0.03))],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            fmb.Surface("sides", marker="box.center", shape=fmb.Cuboid(size=(0.2, 0.1, 0.06)), spacing=0.01),
        ],
        forces=[
            fmb.SurfaceContact("touch", surfaces=("floor", "sides"), law=fmb.ElasticFoundation(1e7, thickness=0.01))
        ],
    )
    return fmb.simulate(model, 2e-3, samples=3)


def test_a_body_is_hidden_with_the_surfaces_that_are_drawn_in_its_place(box_on_floor):
    scene = Scene(box_on_floor)
    assert [part.name for part in scene.parts] == ["floor", "sides", "touch"]
    require_hidden([scene], ("box", "ground"))
    assert hidden_parts(scene, ("box", "joints")) == ("sides", "joints")
    with pytest.raises(FlexmbError, match=r"hide names 'bos'.*Did you mean 'box'"):
        require_hidden([scene], ("bos",))
    with pytest.raises(FlexmbError, match="everything is hidden"):
        require_hidden([scene], ("box", "ground", "touch"))


@pytest.mark.parametrize("size", [(1600, 900), (1000, 600), (640, 360), (400, 300)])
def test_a_colour_scale_fits_into_its_picture(size):
    """Letters are some 0.55 of their height wide: numbers of six are apart, the title does not leave the picture."""
    shown = bar(CONTACT_LABEL, 2e-3, size)
    assert shown["n_labels"] * 6 * 0.55 * shown["label_font_size"] < shown["width"] * size[0]
    middle = (0.03 + 0.5 * shown["width"]) * size[0]
    assert 0.5 * len(CONTACT_LABEL) * 0.55 * shown["title_font_size"] < middle
    assert shown["title_font_size"] + shown["label_font_size"] < shown["height"] * size[1]


@pytest.mark.render
def test_areas_of_contact_do_not_shine_through(box_on_floor, tmp_path):
    """Squares below a box that stands are behind it: at most a thin line of them is seen along its lower edges."""
    import pyvista

    def pixels(name, hide):
        path = render(box_on_floor, tmp_path / name, size=(640, 360), hide=hide)
        drawn = pyvista.read(path).point_data.active_scalars.astype(float).reshape(360, 640, -1)
        return drawn[:, 260:]  # right of the scale of colours

    apart = np.abs(pixels("all.png", ()) - pixels("none.png", ("touch",))).max(axis=2) > 30
    assert 0 < np.abs(pixels("below.png", ("box",)) - pixels("bare.png", ("box", "touch"))).max()
    assert apart.mean() < 2e-3
