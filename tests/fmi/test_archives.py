"""Foreign units are archives: what would fill the disk, leave the folder or multiply is refused before unpacking."""

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
        ({ABOUT: b"no description"}, "it cannot be read"),
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
