"""Files that announce more than they hold, or unpack to far more: a message, and no memory taken for it."""

import base64
import io
import json
import resource
import struct
import sys
import threading
import zipfile
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb
from flexmb import fem, fmi
from flexmb.errors import FlexmbError
from flexmb.fem.announced import require_counts
from flexmb.fem.foreign_memory import memory_for, no_more_than
from flexmb.fem.surface_file import read_triangles

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of Linux")
MANY = 10**8
"""Points: 2.4 GB, which most machines would give."""
MOST = 1e9
"""Bytes of address space, at most, that a reader takes until it refuses such a file."""
VTK = b"# vtk DataFile Version 3.0\nx\n%s\nDATASET %s\n"
GMSH = b"$MeshFormat\n%s 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n"
VTU = (
    '<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
    'header_type="UInt64" {}><UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1"><Points>'
    '<DataArray type="Float64" NumberOfComponents="3" {}</DataArray></Points><Cells>'
    '<DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3</DataArray>'
    '<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray>'
    '<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells></Piece></UnstructuredGrid>{}</VTKFile>'
)


def coded(*numbers, behind=b""):
    return base64.b64encode(struct.pack(f"<{len(numbers)}Q", *numbers) + behind).decode()


def appended(offset, size):
    return VTU.format(
        "",
        f'format="appended" offset="{offset}">',
        f'<AppendedData encoding="base64">_{coded(size, behind=b"x" * 96)}</AppendedData>',
    ).encode()


def unpacking(size):
    """Blocks of zeros, each of them in some kilobytes."""
    block = zlib.compress(bytes(size // 8), 9)
    head = coded(8, size // 8, 0, *[len(block)] * 8)
    body = base64.b64encode(8 * block).decode()
    return VTU.format('compressor="vtkZLibDataCompressor"', f'format="binary">{head}{body}', "").encode()


def scene(count, length):
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": length}] * 2
    kinds = ((5126, "VEC3"), (5125, "SCALAR"))
    text = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": length}],
        "bufferViews": views,
        "accessors": [
            {"bufferView": k, "componentType": code, "count": count, "type": kind}
            for k, (code, kind) in enumerate(kinds)
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    code = json.dumps(text).encode()
    code += b" " * (-len(code) % 4)
    head = b"glTF" + struct.pack("<III", 2, 28 + len(code) + 64, len(code)) + b"JSON"
    return head + code + struct.pack("<I", length) + b"BIN\0" + bytes(64)


def record(*parts):
    data = b"".join(parts)
    return struct.pack("<i", len(data)) + data + struct.pack("<i", len(data))


def output4(rows, start, words):
    """A matrix in OUTPUT4 whose only column begins at a row and has so many words."""
    head = record(struct.pack("<4i", 4, rows, 2, 2), b"KGG     ")
    column = record(struct.pack("<3i", 1, start, words), bytes(16))
    return head + column + record(struct.pack("<3i", 5, 1, 1), bytes(8))


BLOCK = b"    -1\n%s\n    -1\n"
NODE = BLOCK % b"  2411\n         1         1         1         1\n   0.0   0.0   0.0"
MESHES = {
    "points.vtk": VTK % (b"BINARY", b"UNSTRUCTURED_GRID") + b"POINTS %d double\n" % MANY + bytes(96),
    "text.vtk": VTK % (b"ASCII", b"UNSTRUCTURED_GRID") + b"POINTS %d double\n0 0 0\n" % MANY,
    "grid.vtk": VTK % (b"ASCII", b"STRUCTURED_POINTS") + b"DIMENSIONS %d 2 2\nORIGIN 0 0 0\nSPACING 1 1 1\n" % MANY,
    "offset.vtu": appended(4 * 10**9, 96),
    "before.vtu": appended(-40, 96),
    "size.vtu": appended(0, 10**15),
    "blocks.vtu": VTU.format(
        'compressor="vtkZLibDataCompressor"', f'format="binary">{coded(10**15, 1 << 20, 0)}', ""
    ).encode(),
    "unpacks.vtu": unpacking(3 << 28),
    "nodes.msh": GMSH % b"4.1" + b"$Nodes\n" + struct.pack("<QQQQiiiQ", 1, MANY, 1, MANY, 3, 1, 0, MANY) + bytes(100),
    "nodes2.msh": GMSH % b"2.2" + b"$Nodes\n%d\n" % MANY + bytes(280),
    "entities.msh": GMSH % b"4.1" + b"$Entities\n" + struct.pack("<QQQQ", 10**15, 0, 0, 0) + bytes(64),
    "text.msh": b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 %d 1 9\n3 1 0 %d\n1\n0 0 0\n" % (MANY, MANY),
    "binary.unv": BLOCK % (b"    58b     1     2 %d %d 0 0 0 0 0\n" % (10**18, 10**18) + b"x" * 50),
    "corners.unv": NODE + BLOCK % (b"  2412\n 1 111 1 1 7 %d\n 1 1 1 1" % 10**9),
    "members.unv": NODE + BLOCK % (b"  2467\n 1 0 0 0 0 0 0 %d\nname\n 8 1 0 0" % 10**9),
}
SURFACES = {
    "count.stl": bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(200),
    "count.glb": scene(10**9, 4 * 10**9),
    "length.glb": b"glTF" + struct.pack("<III", 2, 100, 4 * 10**9) + b"JSON{}",
    "circle.gltf": b'{"asset": {"version": "2.0"}, "nodes": [{"children": [0]}], "scenes": [{"nodes": [0]}]}',
    "other.xdmf": b'<Xdmf Version="3.0"><Domain></Domain></Xdmf>',
    "points.vtk": MESHES["points.vtk"],
    "grid.vtk": MESHES["grid.vtk"],
    "size.vtu": MESHES["size.vtu"],
}
MATRICES = {
    "mark.op2": struct.pack("<4i", 4, 3, 4, 2**31 - 5) + bytes(100),
    "mark.op4": struct.pack("<i", 2**31 - 1) + bytes(30),
    "rows.op4": output4(2**31 - 1, 1, 4),
    "start.op4": output4(4, 10**9, 4),
    "words.op4": output4(4, 1, 10**9),
}
ARCHIVE = b"/PREP7\nET,1,185\nNBLOCK,6,SOLID,%d,%d\n(%di9,6e21.13e3)\n        1        0        0 0.0\nN,R5.3,LOC,-1,\n"
CORNERS = b"EBLOCK,19,SOLID,%d,%d\n(19i9)\n" % (MANY, MANY) + b"%9d" * 12 % (*[1] * 8, MANY, 0, 1, 1) + b"\n       -1\n"
DECKS = {
    "nodes.cdb": ARCHIVE % (10**18, 10**18, 3),
    "format.cdb": ARCHIVE % (1, 1, 10**9),
    "corners.cdb": ARCHIVE % (1, 1, 3) + CORNERS,
    "members.cdb": ARCHIVE % (1, 1, 3) + b"CMBLOCK,A,NODE,%d\n(8i10)\n         1%10d\n" % (MANY, -MANY),
}


@pytest.mark.parametrize(
    ("layout", "attributes"),
    [("inline", ""), ("inline", ' header_type="UInt64"'), ("base64", ' header_type="UInt64"'), ("raw", "")],
)
def test_sizes_of_compressed_arrays_are_read_from_their_headers(tmp_path, layout, attributes):
    """17 blocks of a gigabyte, of which no byte is there: nothing is unpacked to find that out."""
    head = struct.pack("<17Q" if attributes else "<17I", 17, 10**9, 5, *[100] * 14)
    data = head if layout == "raw" else base64.b64encode(head)
    array = b'format="binary">' + data if layout == "inline" else b'format="appended" offset="0">'
    store = b'<AppendedData encoding="%s">_%s</AppendedData>' % (layout.encode(), data) if layout != "inline" else b""
    text = (
        b'<VTKFile type="UnstructuredGrid" byte_order="LittleEndian"%s compressor="vtkZLibDataCompressor">'
        b'<UnstructuredGrid><Piece NumberOfPoints="9" NumberOfCells="1">'
        b'<Points><DataArray type="Float64" %s</DataArray>'
        b"</Points></Piece></UnstructuredGrid>%s</VTKFile>"
    ) % (attributes.encode(), array, store)
    (tmp_path / "large.vtu").write_bytes(text)
    with pytest.raises(FlexmbError, match=r"its arrays unpack to 1\.6e\+04 MB; at most 600.* MB are read"):
        fem.read_mesh(tmp_path / "large.vtu")


def peak():
    """bytes of address space, at most so far"""
    with open("/proc/self/status") as text:
        return next(1024 * int(line.split()[1]) for line in text if line.startswith("VmPeak"))


def taken_until_refused(path, read):
    """bytes of address space taken before the reader says that it does not read the file"""
    before = peak()
    with pytest.raises(FlexmbError):
        read(path)
    return peak() - before


@pytest.mark.parametrize("name", MESHES)
def test_meshes(tmp_path, name):
    (tmp_path / name).write_bytes(MESHES[name])
    assert taken_until_refused(tmp_path / name, fem.read_mesh) < MOST


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("name", SURFACES)
def test_surfaces(tmp_path, name):
    if name.endswith(("glb", "gltf")):
        pytest.importorskip("trimesh")
    (tmp_path / name).write_bytes(SURFACES[name])
    assert taken_until_refused(tmp_path / name, read_triangles) < MOST


@pytest.mark.parametrize("name", MATRICES)
def test_matrices(tmp_path, name):
    pytest.importorskip("pyyeti")
    (tmp_path / name).write_bytes(MATRICES[name])
    assert taken_until_refused(tmp_path / name, lambda path: fem.read_matrices(path, np.zeros((4, 3)))) < MOST


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", DECKS)
def test_decks(tmp_path, name):
    (tmp_path / name).write_bytes(DECKS[name])
    assert taken_until_refused(tmp_path / name, fem.read_deck) < MOST


def test_voxels_of_a_byte_each(tmp_path):
    """A grid has more points than cells, and a file of cells may have a byte for each of these."""
    n = 121
    data = b"DIMENSIONS %d %d %d\nORIGIN 0 0 0\nSPACING 1 1 1\nCELL_DATA %d\n" % (n, n, n, (n - 1) ** 3)
    data += b"SCALARS part unsigned_char 1\nLOOKUP_TABLE default\n" + bytes((n - 1) ** 3)
    (tmp_path / "voxels.vtk").write_bytes(VTK % (b"BINARY", b"STRUCTURED_POINTS") + data)
    assert n**3 > (tmp_path / "voxels.vtk").stat().st_size > 1_000_000
    require_counts(tmp_path / "voxels.vtk")


def test_arrays_that_unpack(tmp_path):
    """A tenth of a megabyte of an .npz file that unpacks to 128 MB."""
    shape = io.BytesIO()
    np.lib.format.write_array_header_1_0(shape, {"descr": "<f8", "fortran_order": False, "shape": (1 << 24,)})
    with (
        zipfile.ZipFile(tmp_path / "K.npz", "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("data.npy", "w", force_zip64=True) as stream,
    ):
        stream.write(shape.getvalue())
        for _ in range(8):
            stream.write(bytes(1 << 24))
    with pytest.raises(FlexmbError, match=r"unpack to 134\.2 MB"):
        fem.read_matrices(tmp_path / "K.npz", np.zeros((4, 3)), mass=tmp_path / "K.npz")


def test_chunks_that_unpack(tmp_path):
    """Compressed zeros of 128 MB in an HDF5 file without a seal, and a terabyte that was never written."""
    for name, size in (("zeros", 1 << 24), ("nothing", 1 << 37)):
        with h5py.File(tmp_path / f"{name}.h5", "w") as file:
            data = file.create_dataset("x", (size,), "f8", chunks=(1 << 20,), compression="gzip")
            if name == "zeros":
                data[:] = 0.0
        with pytest.raises(FlexmbError, match="the datasets up to 'x'"):
            fmb.ModalNeutralData.load(tmp_path / f"{name}.h5")


def test_a_unit_whose_directory_lies(tmp_path):
    """It says 1000 bytes of a description that unpacks to 201 MB."""
    size = (3 << 26) + 7
    with zipfile.ZipFile(tmp_path / "a.fmu", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", b"<a>" + bytes(3 << 26) + b"</a>")
    lying = (tmp_path / "a.fmu").read_bytes().replace(struct.pack("<I", size), struct.pack("<I", 1000))
    (tmp_path / "a.fmu").write_bytes(lying)
    load = fmb.PointLoad("push", marker="m.center", force=(fmb.input("force"), 0, 0))
    model = fmb.Model(bodies=[fmb.Ground(), fmb.PointMass("m", mass=1.0)], forces=[load])
    unit = fmi.Fmu(tmp_path / "a.fmu", inputs={"force": "x"}, outputs={"force": "y"})
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(FlexmbError, match="Fmu"):
        fmi.cosimulate(model, unit, 0.01, step=0.01)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 150_000


@pytest.mark.parametrize("read", [fem.read_mesh, slow(read_triangles)])
def test_headers_of_less_than_the_blocks_unpack_to(tmp_path, monkeypatch, read):
    """8 MB whose header speaks of 96 bytes unpack to 8 GB: 0.4 GB, and not 1.7 GB, are unpacked until it is refused."""
    press = zlib.compressobj(9, wbits=-15)
    block = b"\x78\xda" + 512 * (press.compress(bytes(1 << 24)) + press.flush(zlib.Z_FULL_FLUSH)) + press.flush()
    head, body = coded(1, 96, 0, len(block)), base64.b64encode(block).decode()
    text = VTU.format('compressor="vtkZLibDataCompressor"', f'format="binary">{head}{body}', "")
    (tmp_path / "lying.vtu").write_text(text)
    monkeypatch.setattr(threading, "active_count", lambda: 1)  # whatever other tests left
    Path("/proc/self/clear_refs").write_text("5")  # the largest size so far is the present one
    before = resident()
    with pytest.raises(FlexmbError, match="asks for more memory"):
        read(tmp_path / "lying.vtu")
    assert resident() - before < 500e6


def resident():
    """bytes of memory, at most since the last reset"""
    with open("/proc/self/status") as text:
        return next(1024 * int(line.split()[1]) for line in text if line.startswith("VmHWM"))


def test_compressed_zeros_are_read(tmp_path):
    """8 MB of a field of zeros in a file of some 80 kB: what sound headers announce may be taken."""
    meshio = pytest.importorskip("meshio")
    n = 20
    place = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, n)] * 3, indexing="ij"), -1).reshape(-1, 3)
    at = np.arange(n**3).reshape(n, n, n)
    corners = [
        at[i : n - 1 + i, j : n - 1 + j, k : n - 1 + k] for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))
    ]
    cells = np.stack(corners, -1).reshape(-1, 8)
    zeros = {"load": np.zeros((len(place), 128))}
    meshio.write(tmp_path / "zeros.vtu", meshio.Mesh(place, [("hexahedron", cells)], point_data=zeros))
    assert (tmp_path / "zeros.vtu").stat().st_size < 150_000
    assert len(fem.read_mesh(tmp_path / "zeros.vtu").points) == n**3


def test_the_limit_is_taken_back(tmp_path):
    (tmp_path / "a").write_bytes(b"")
    before = resource.getrlimit(resource.RLIMIT_AS)
    with memory_for(tmp_path / "a"):
        inner = resource.getrlimit(resource.RLIMIT_AS)
        with memory_for(tmp_path / "a"):
            assert resource.getrlimit(resource.RLIMIT_AS) == inner
        assert resource.getrlimit(resource.RLIMIT_AS) == inner != before
        with pytest.raises(MemoryError):
            np.ones(1 << 28)
    assert resource.getrlimit(resource.RLIMIT_AS) == before


def test_other_threads_are_not_held_to_what_one_file_announces(tmp_path, monkeypatch):
    (tmp_path / "a").write_bytes(b"")
    done = threading.Event()
    other = threading.Thread(target=done.wait, daemon=True)
    with memory_for(tmp_path / "a"):
        wide = resource.getrlimit(resource.RLIMIT_AS)
        other.start()
        no_more_than(200_000_000)
        assert resource.getrlimit(resource.RLIMIT_AS) == wide
        done.set()
        other.join()
        monkeypatch.setattr(threading, "active_count", lambda: 1)
        no_more_than(200_000_000)
        assert resource.getrlimit(resource.RLIMIT_AS)[0] < wide[0]
