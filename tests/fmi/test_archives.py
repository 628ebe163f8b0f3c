"""Foreign units are archives: what would fill the disk, leave the folder or multiply is refused before unpacking."""

import copy
import stat
import time
import warnings
import zipfile

import pytest

import flexmb as fmb
from flexmb.fmi import archive

MODEL = fmb.Model(bodies=[fmb.Ground(), fmb.PointMass("m", mass=1.0)], sensors=[fmb.Position("x", marker="m.center")])
ABOUT = "modelDescription.xml"


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({"../outside.txt": b"x", ABOUT: b"<a/>"}, "outside the archive"),
        ({"/etc/outside": b"x", ABOUT: b"<a/>"}, "outside the archive"),
        ({"other.xml": b"<a/>"}, "no modelDescription.xml"),
        ({ABOUT: b'<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>'}, "defines entities"),
        ({ABOUT: b"<a/>", "large.bin": bytes(3000)}, "are unpacked"),
        ({ABOUT: b"no description"}, "no text of XML"),
        ({ABOUT: b"<a"}, "it cannot be read"),
        ({ABOUT: "<!DOCTYPE a><a/>".encode("utf-16")}, "not written in UTF-8"),
        ({ABOUT: "<!DOCTYPE a><a/>".encode("utf-16-le")}, "not written in UTF-8"),
        ({ABOUT: b'<?xml version="1.0" encoding="UTF-7"?>+ADwAIQ-DOCTYPE a><a/>'}, "written in UTF-7"),
        ({ABOUT: "<?xml?><!DOCTYPE a><a/>".encode("cp500")}, "no text of XML"),
    ],
)
def test_refused(tmp_path, monkeypatch, files, message):
    pytest.importorskip("fmpy")
    monkeypatch.setattr(archive, "LARGEST", 2000)
    with zipfile.ZipFile(tmp_path / "unit.fmu", "w", zipfile.ZIP_DEFLATED) as made:
        for name, content in files.items():
            made.writestr(name, content)
    with pytest.raises(fmb.DataFileError, match=message):
        fmb.fmi.cosimulate(MODEL, fmb.fmi.Fmu(tmp_path / "unit.fmu"), 0.01, step=0.01)


def test_no_archive(tmp_path):
    pytest.importorskip("fmpy")
    (tmp_path / "unit.fmu").write_bytes(b"PK\x03\x04 cut off")
    with pytest.raises(fmb.DataFileError, match="cannot be read"):
        fmb.fmi.cosimulate(MODEL, fmb.fmi.Fmu(tmp_path / "unit.fmu"), 0.01, step=0.01)


def described(tmp_path, encoding):
    """Return a unit whose description declares an encoding."""
    with zipfile.ZipFile(tmp_path / "unit.fmu", "w") as made:
        made.writestr(ABOUT, f'<?xml version="1.0" encoding="{encoding}"?><a/>')
    return tmp_path / "unit.fmu"


@pytest.mark.parametrize(
    "encoding",
    ["UTF-8", "utf8", "UTF8", "ASCII", "US-ASCII", "latin-1", "ISO-8859-1", "iso8859-15", "ISO_8859-2", "windows-1252"],
)
def test_extensions_of_ascii_by_any_name(tmp_path, encoding):
    archive.require_archive(described(tmp_path, encoding), "Fmu")


@pytest.mark.parametrize(
    "encoding",
    ["UTF-7", "UTF-16", "utf_8_sig", "cp500", "EBCDIC-CP-US", "rot13", "hex", "", "no such", "../utf_8", 99 * "u"],
)
def test_other_encodings(tmp_path, encoding):
    with pytest.raises(fmb.DataFileError, match=f"is written in {encoding[:40]}, not in UTF-8"):
        archive.require_archive(described(tmp_path, encoding), "Fmu")


TEN = "".join(f'<!ENTITY e{k + 1} "{10 * f"&e{k};"}">' for k in range(9))
BOMB = f'<!DOCTYPE a [<!ENTITY e0 "0123456789">{TEN}]><fmiModelDescription>&e9;</fmiModelDescription>'.encode()


def refused(path, message):
    """Nothing of it is unpacked: the seconds of the processor that it takes to say so."""
    pytest.importorskip("fmpy")
    began = time.process_time()
    with pytest.raises(fmb.DataFileError, match=message):
        fmb.fmi.cosimulate(MODEL, fmb.fmi.Fmu(path), 0.01, step=0.01)
    return time.process_time() - began


def test_what_links_doubles_or_comes_twice(tmp_path):
    """A description of 10 GB of entities, a link to a file of the machine, and a harmless description before the one
    that would be read."""
    link = zipfile.ZipInfo("resources/key")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    for entries, message in (
        ([(ABOUT, BOMB)], "defines entities"),
        ([(ABOUT, b"<a/>"), (link, b"/etc/hostname")], "a link called 'resources/key'"),
        ([(ABOUT, b"<a/>"), (ABOUT, BOMB)], "two files called 'modelDescription.xml'"),
        ([(ABOUT, b"<a/>"), (f"./{ABOUT}", BOMB)], "two files called './modelDescription.xml'"),
    ):
        with warnings.catch_warnings(), zipfile.ZipFile(tmp_path / "unit.fmu", "w") as made:
            warnings.simplefilter("ignore", UserWarning)  # of the name that comes twice
            for name, content in entries:
                made.writestr(name, content)
        assert refused(tmp_path / "unit.fmu", message) < 0.5


def test_a_small_archive_that_asks_for_gigabytes(tmp_path):
    """3 GB of zeros in 13 kB, each file an entry that names the same bytes: Fifield, A better zip bomb, WOOT 2019."""
    with zipfile.ZipFile(tmp_path / "unit.fmu", "w", zipfile.ZIP_DEFLATED) as made:
        made.writestr(ABOUT, b"<a/>")
        made.writestr("zeros", bytes(10_000_000))
        entry = made.getinfo("zeros")
        for k in range(300):
            again = copy.copy(entry)
            again.filename = f"zeros{k}"
            made.filelist.append(again)
    assert (tmp_path / "unit.fmu").stat().st_size < 50_000
    assert refused(tmp_path / "unit.fmu", "302 files of 3010 MB; at most 50000 of 100") < 0.5
