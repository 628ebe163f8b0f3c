"""Scenes of glTF 2.0 whose points a reader without their extension takes for zeros, and infinite points of surfaces."""

import copy
import json
import struct

import numpy as np
import pytest

from flexmb.errors import MeshError
from flexmb.fem.surface_file import read_surface, read_triangles

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
BYTES = POINTS.tobytes() + np.array([0, 1, 2], "<u2").tobytes()
SCENE = {
    "asset": {"version": "2.0"},
    "scene": 0,
    "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
    ],
    "bufferViews": [
        {"buffer": 0, "byteOffset": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": 6},
    ],
    "buffers": [{"byteLength": 42}],
}


def glb(scene, numbers=BYTES):
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    numbers += bytes(-len(numbers) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(numbers), b"BIN\0") + numbers
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


@pytest.fixture
def read(tmp_path):
    pytest.importorskip("trimesh")

    def of(scene, numbers=BYTES):
        (tmp_path / "part.glb").write_bytes(glb(scene, numbers))
        return read_triangles(tmp_path / "part.glb", scale=2.0)

    return of


def test_a_plain_scene(read):
    scene = copy.deepcopy(SCENE)
    scene["extensionsUsed"] = scene["extensionsRequired"] = ["KHR_materials_unlit"]
    points, triangles = read(scene)
    np.testing.assert_array_equal(points, 2.0 * POINTS)
    np.testing.assert_array_equal(triangles, [[0, 1, 2]])


@pytest.mark.parametrize(
    "name",
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_mesh_quantization", "EXT_mesh_gpu_instancing"],
)
def test_extensions_of_points_are_refused(read, name):
    """trimesh alone reads the first as zeros."""
    scene = copy.deepcopy(SCENE)
    scene["extensionsUsed"] = scene["extensionsRequired"] = [name]
    for accessor in scene["accessors"]:
        del accessor["bufferView"]
    with pytest.raises(MeshError, match=f"needs the extensions {name} of glTF.*Export without compression"):
        read(scene)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"sparse": {"count": 1}}, "points that are stored as changes"),
        ({"bufferView": None}, "points without numbers"),
        ({"componentType": 5122, "normalized": True}, "points as scaled integers"),
    ],
)
def test_points_that_are_no_plain_numbers_are_refused(read, change, found):
    scene = copy.deepcopy(SCENE)
    scene["accessors"][0].update(change)
    scene["accessors"][0] = {key: value for key, value in scene["accessors"][0].items() if value is not None}
    with pytest.raises(MeshError, match=found):
        read(scene)


@pytest.mark.parametrize("wrong", [np.inf, np.nan])
def test_points_at_infinity_are_refused(read, wrong):
    points = POINTS.copy()
    points[2, 1] = wrong
    with pytest.raises(MeshError, match=f"coordinates with {wrong} at place 3"):
        read(SCENE, points.tobytes() + BYTES[36:])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 {} 0\nf 1 2 3\n"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 {} 0\n3 0 1 2\n"),
    ],
)
@pytest.mark.parametrize("wrong", ["inf", "nan", "1e400"])
def test_infinite_numbers_of_meshes_are_refused(tmp_path, name, text, wrong):
    (tmp_path / name).write_text(text.format(wrong))
    with pytest.raises(MeshError, match=r"coordinates with (inf|nan) at place 3.*finite numbers"):
        read_triangles(tmp_path / name)


@pytest.mark.parametrize(
    ("row", "found"),
    [
        ("inf,0,0,1,0,0,1", "coordinates"),
        ("0,0,0,nan,0,0,1", "pressures"),
        ("0,0,0,1,0,0,1e400", "areas or normals"),
    ],
)
def test_infinite_numbers_of_tables_are_refused(tmp_path, row, found):
    (tmp_path / "p.csv").write_text(f"x,y,z,p,ax,ay,az\n0,0,0,1,0,0,1\n{row}\n")
    with pytest.raises(MeshError, match=f"{found} with (inf|nan) at place 2"):
        read_surface(tmp_path / "p.csv")
