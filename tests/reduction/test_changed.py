"""Data in other axes or units equal the reduction of the FE model in these axes or units."""

import numpy as np
import pytest
from reduction.solids import STEEL, block_mesh
from scipy.spatial.transform import Rotation

from flexmb import fem, reduction
from flexmb.bodies import FloatingBody
from flexmb.errors import ModelError, ReductionError
from flexmb.model.material import Material

OPTIONS = {
    "modes": 3,
    "geometric_stiffness": True,
    "stations": {"m": "mid"},
    "compare": 2,
}


def reduced(points=lambda x: x, material=STEEL, **options):
    mesh = block_mesh((0.4, 0.06, 0.04), (4, 2, 1))
    cells, tops = mesh.cells[0][1], mesh.facet_sets["top"]
    moved = points(mesh.points)
    if np.linalg.det(points(np.eye(3)) - points(np.zeros((3, 3)))) < 0:  # a mirror turns cells and facets inside out
        cells, tops = cells[:, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]], tops[:, [0, 2, 1, 5, 4, 3]]
    model = fem.solid(
        fem.Mesh(points=moved, cells=(("tetra10", cells),), node_sets=mesh.node_sets, facet_sets={"top": tops}),
        material,
    )
    drag = reduction.Pressure("top", direction=np.ravel(points(np.array([[1.0, 0.0, 0.5]])) - points(np.zeros((1, 3)))))
    asked = OPTIONS | {"loads": {"air": "top", "drag": drag}} | options
    if asked["geometric_stiffness"]:
        asked = {"preload": {"air": 20.0, "drag": 5.0}} | asked
    return reduction.reduce(model, {"a": "left", "b": "right"}, **asked)


def assert_same_body(found, expected, tolerance=1e-7):
    """Equal up to the signs of the modes."""
    signs = np.sign(np.einsum("naj,naj->j", found.shapes, expected.shapes))
    for name in ("nodes", "marker_positions", "frequencies"):
        np.testing.assert_allclose(
            getattr(found, name), getattr(expected, name), atol=1e-9 * np.abs(getattr(expected, name)).max()
        )
    both = np.outer(signs, signs)

    def close(a, b, sign, name):
        np.testing.assert_allclose(a * sign, b, atol=tolerance * max(np.abs(b).max(initial=0.0), 1e-12), err_msg=name)

    for name in ("shapes", "marker_translations", "marker_rotations", "stress_modes"):
        close(getattr(found, name), getattr(expected, name), signs, name)
    close(found.load_shapes, expected.load_shapes, np.r_[np.ones(6), signs], "load_shapes")
    six = np.r_[np.ones(6), signs]
    close(found.load_turning, expected.load_turning, np.outer(six, signs), "load_turning")
    if expected.preload_turning is not None:
        close(found.preload_turning, expected.preload_turning, np.outer(six, signs), "preload_turning")
    i, j = found.invariants, expected.invariants
    size = np.abs(j.ww0).max()
    for name, sign in (
        ("vv", 1),
        ("vw0", 1),
        ("ww0", 1),
        ("vw1", signs[:, None, None]),
        ("ww1", signs[:, None, None]),
        ("ww2", both[:, :, None, None]),
        ("nn", both),
        ("wn1", signs[:, None, None] * signs),
    ):
        np.testing.assert_allclose(
            getattr(i, name) * sign, getattr(j, name), atol=tolerance * max(size, 1.0), err_msg=name
        )
    for name, sign in (("inertia", both), ("interface", both), ("loads", both), ("preload", both)):
        close(getattr(found.geometric, name), getattr(expected.geometric, name), sign, name)
    np.testing.assert_allclose(found.quality["mass"]["inertia"], expected.quality["mass"]["inertia"], atol=1e-9 * size)
    np.testing.assert_allclose(
        found.quality["modes"][0]["frequency"], expected.quality["modes"][0]["frequency"], rtol=1e-9
    )


@pytest.mark.parametrize("frame", ["buckens", "a"])
def test_moved(frame):
    turn, origin = Rotation.from_rotvec([0.3, -0.8, 0.5]), np.array([0.1, -0.3, 0.2])
    expected = reduced(lambda x: turn.inv().apply(x - origin), frame=frame)
    found = reduced(frame=frame)
    for rotation in (turn, turn.as_matrix(), turn.as_rotvec()):
        assert_same_body(reduction.moved(found, rotation, origin), expected)


def test_there_and_back():
    data = reduced()
    turn = Rotation.from_rotvec([0.3, -0.8, 0.5])
    there = reduction.moved(data, turn, (0.1, 0.2, 0.3))
    assert_same_body(reduction.moved(there, turn.inv(), -turn.inv().apply([0.1, 0.2, 0.3])), data, 1e-12)


def test_mirrored():
    n = np.array([0.6, 0.0, 0.8])
    expected = reduced(lambda x: x - 2 * np.outer(x @ n, n))
    image = reduction.mirrored(reduced(), 2 * n, name="right")
    assert image.name == "right"
    assert_same_body(image, expected)
    np.testing.assert_array_equal(image.cells[0][1], expected.cells[0][1])


def test_planes_by_name():
    data = reduced(geometric_stiffness=False)
    for plane, normal in (("yz", (1, 0, 0)), ("xz", (0, 1, 0)), ("xy", (0, 0, 1))):
        np.testing.assert_array_equal(data.mirrored(plane).nodes, data.mirrored(normal).nodes)
        np.testing.assert_array_equal(data.mirrored(plane).nodes, data.nodes * (1 - 2 * np.array(normal)))


def test_rotated_and_translated():
    """The part is turned about its origin, then moved: x' = R x + d."""
    turn, d = Rotation.from_rotvec([0.3, -0.8, 0.5]), np.array([0.1, -0.3, 0.2])
    expected = reduced(lambda x: turn.apply(x) + d)
    data = reduced()
    for rotation in (turn, turn.as_matrix(), turn.as_rotvec()):
        assert_same_body(data.rotated(rotation).translated(d), expected)


@pytest.mark.parametrize("change", [Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix(), np.diag([1.0, -1.0, 1.0])])
def test_effective_mass_follows_the_axes(change):
    expected = reduced(lambda x: x @ change.T).quality["effective_mass"]
    data = reduced()
    table = (data.mirrored("xz") if change[1, 1] == -1.0 else data.rotated(change)).quality["effective_mass"]
    assert table["directions"] == expected["directions"]
    np.testing.assert_allclose(table["per_mode"], expected["per_mode"], atol=1e-8)
    np.testing.assert_allclose(table["sum"], expected["sum"], atol=1e-8)


def test_rescaled_from_tonnes_and_millimetres():
    """The same part in mm, t, s (E in MPa, density in t/mm3) is the SI part after rescaling."""
    odd = Material(young=210e3, poisson=0.3, density=7.85e-9)
    data = reduced(lambda x: 1e3 * x, odd)
    found, expected = reduction.rescaled(data, length=1e-3, mass=1e3), reduced()
    np.testing.assert_allclose(found.frequencies, expected.frequencies, rtol=1e-9)
    np.testing.assert_allclose(found.mass, expected.mass, rtol=1e-12)
    np.testing.assert_allclose(found.inertia, expected.inertia, atol=1e-12)
    np.testing.assert_allclose(
        np.diag(found.stiffness) / np.diag(found.invariants.nn), np.diag(expected.stiffness), rtol=1e-9
    )
    tip = [
        d.marker_translations[1] @ np.linalg.solve(d.stiffness, d.marker_translations[1].T) for d in (found, expected)
    ]
    np.testing.assert_allclose(tip[0], tip[1], atol=1e-9 * np.abs(tip[1]).max())  # flexibility, m/N
    turn = [d.marker_rotations[1] @ np.linalg.solve(d.stiffness, d.marker_translations[1].T) for d in (found, expected)]
    np.testing.assert_allclose(turn[0], turn[1], atol=1e-9 * np.abs(turn[1]).max())  # rad/N
    unit = np.sqrt(np.diag(found.invariants.nn))  # modes of unit mass in tonnes have 1000 kg
    both = np.outer(unit, unit)
    signs = np.sign(np.einsum("naj,naj->j", found.shapes, expected.shapes))
    signs = np.outer(signs, signs)
    for name in ("inertia", "interface"):
        a, b = getattr(found.geometric, name) / both * signs, getattr(expected.geometric, name)
        np.testing.assert_allclose(a, b, atol=1e-7 * np.abs(b).max(), err_msg=name)
    stress = found.stress_modes @ np.linalg.solve(found.stiffness, found.marker_translations[1, 2])
    np.testing.assert_allclose(
        stress,
        expected.stress_modes @ np.linalg.solve(expected.stiffness, expected.marker_translations[1, 2]),
        atol=1e-7 * np.abs(stress).max(),
    )


def test_refused_changes():
    data = reduced()
    with pytest.raises(ReductionError, match=r"(?s)a rotation .*a proper orthogonal matrix.*Use data\.mirrored"):
        reduction.moved(data, np.diag([1.0, 1.0, -1.0]))
    for plane in ((0, 0, 0), "xw", (1, 0)):
        with pytest.raises(ReductionError, match=r"the plane .* 'xy', 'yz', 'xz', or a normal: three numbers, not all"):
            data.mirrored(plane)
    with pytest.raises(ReductionError, match=r"displacement \(1, 2\)\. Expected: three numbers, m\. Write \(x, y, z\)"):
        data.translated((1, 2))
    with pytest.raises(ReductionError, match=r"unit factors 0\.0, 1\.0, 1\.0\. Expected: positive numbers"):
        reduction.rescaled(data, length=0.0)


def test_a_similar_body_is_that_of_the_enlarged_mesh():
    """All lengths times 1.3, same material: the body of the data enlarged is the reduction of the mesh enlarged."""
    body = FloatingBody.similar("larger", data=reduced(), scale=1.3)
    found, expected = body.data, reduced(lambda x: 1.3 * x)
    np.testing.assert_allclose(found.nodes, expected.nodes, atol=1e-12)
    np.testing.assert_allclose(found.frequencies, expected.frequencies, rtol=1e-9)
    assert found.mass == pytest.approx(expected.mass, rel=1e-12)
    np.testing.assert_allclose(found.inertia, expected.inertia, rtol=1e-9, atol=1e-12)
    for shape in (np.s_[1, 2], np.s_[1, 1]):  # a unit force at the end: displacement and stress everywhere
        bent = [np.linalg.solve(d.stiffness, d.marker_translations[shape]) for d in (found, expected)]
        moved = [d.shapes @ eta for d, eta in zip((found, expected), bent)]
        np.testing.assert_allclose(*moved, atol=1e-7 * np.abs(moved[1]).max())
        stress = [d.stress_modes @ eta for d, eta in zip((found, expected), bent)]
        np.testing.assert_allclose(*stress, atol=1e-7 * np.abs(stress[1]).max())
    pressure = [np.linalg.solve(d.stiffness, d.load_shapes[0, 6:]) for d in (found, expected)]
    moved = [d.shapes @ eta for d, eta in zip((found, expected), pressure)]
    np.testing.assert_allclose(*moved, atol=1e-7 * np.abs(moved[1]).max())
    data = reduced()
    assert FloatingBody.similar("same", data=data, scale=1.0).data is data
    for scale in (0.0, -1.0, float("nan"), True, "2"):
        with pytest.raises(ModelError, match=r"Body 'b': scale = .* a positive number\. scale=1\.05 makes"):
            FloatingBody.similar("b", data=data, scale=scale)
