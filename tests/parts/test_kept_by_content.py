"""What lies in the cache under the name of a part is taken only if it is that part, whole: its key is compared.

Reference: the mass of a bar, density times area times length.
"""

import os
import shutil
import subprocess
import sys
import warnings

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, parts
from flexmb.cli import main

AREA, STEEL = 1e-4, fmb.MATERIALS["steel"]
SECTION = fem.Section.rectangle(0.01, 0.01)


class Ear(parts.Count):
    """Counts, and hears what is wrong with the cache."""

    def __init__(self):
        super().__init__()
        self.troubles = []

    def trouble(self, part, text):
        self.troubles.append((part, text))


def bar(name="bar", length=1.0):
    line = parts.Line(points=[(0, 0, 0), (length, 0, 0)], elements=2, section=SECTION, material=STEEL)
    return parts.Part(name=name, pieces=[line], interfaces={"a": "start"}, modes=0, compare=0)


def heard(part):
    with parts.watching(Ear()) as ear:
        return part.reduced(), ear


@pytest.fixture(autouse=True)
def folder(monkeypatch, tmp_path):
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "kept"))
    return tmp_path / "kept"


def entry(folder, name):
    (path,) = folder.glob(f"{name}-*.h5")
    return path


@pytest.mark.parametrize("other", [bar("rod", 2.0), bar("bar", 2.0)], ids=["another part", "another length"])
def test_the_file_of_another_part_is_not_taken(folder, other):
    """The whole file of another part under the name of this one: told and made again, with the mass of this one."""
    heard(bar())
    path = entry(folder, "bar")
    heard(other)
    (theirs,) = set(folder.glob("*.h5")) - {path}
    shutil.copy(theirs, path)
    data, ear = heard(bar())
    assert data.mass == pytest.approx(STEEL.density * AREA * 1.0, rel=1e-12)
    assert ear.reduced == 1
    ((part, text),) = ear.troubles
    assert part == "bar"
    assert f"holds part '{other.name}' of another description" in text
    data, ear = heard(bar())
    assert (ear.reduced, ear.reused, ear.troubles) == (0, 1, [])


def test_a_body_that_was_saved_there_is_not_taken(folder):
    """A file of `save` has no key, even where it is the same part."""
    data, _ = heard(bar())
    path = entry(folder, "bar")
    data.rescaled(mass=2.0).save(path)
    again, ear = heard(bar())
    assert again.mass == pytest.approx(STEEL.density * AREA, rel=1e-12)
    assert "was not kept by it" in ear.troubles[0][1]


@pytest.mark.parametrize("damage", ["cut", "bytes", "empty", "text"])
def test_damage_is_told_and_mended(folder, damage, capsys):
    heard(bar())
    path = entry(folder, "bar")
    content = bytearray(path.read_bytes())
    end = content.index(b"FLEXSEAL")
    content[end // 2 : end // 2 + 8] = bytes(255 - b for b in content[end // 2 : end // 2 + 8])
    damaged = {"cut": content[: end // 2], "bytes": content[: end + 24], "empty": b"", "text": b"no data"}
    path.write_bytes(damaged[damage])  # bytes: as of former times, without a parity
    assert main(["cache"]) == 0
    assert f"{path.name}, damaged: " in capsys.readouterr().out
    data, ear = heard(bar())
    assert data.mass == pytest.approx(STEEL.density * AREA, rel=1e-12)
    assert "damaged and is made again" in ear.troubles[0][1]
    (kept,) = parts.kept_bodies()
    assert (kept.name, kept.wrong, kept.current) == ("bar", "", True)


def test_changed_bytes_are_restored_and_told(folder):
    """Nothing is reduced again."""
    heard(bar())
    path = entry(folder, "bar")
    content = bytearray(path.read_bytes())
    content[content.index(b"FLEXSEAL") // 2] ^= 1
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # the list gives no advice about a file that mends itself
        assert [kept.wrong for kept in parts.kept_bodies()] == [""]
    with pytest.warns(UserWarning, match="all of it was restored from its parity"):
        data, ear = heard(bar())
    assert data.mass == pytest.approx(STEEL.density * AREA, rel=1e-12)
    assert (ear.reduced, ear.reused, ear.troubles) == (0, 1, [])


def test_listed_under_what_it_is(folder, capsys):
    """The listing names what is in a file; it goes by the name of its content and by its own."""
    heard(bar())
    heard(bar("rod", 2.0))
    path = entry(folder, "bar")
    shutil.copy(entry(folder, "rod"), path)
    found = {kept.path.name: kept for kept in parts.kept_bodies()}
    assert found[path.name].name == "rod"
    assert main(["cache"]) == 0
    out = capsys.readouterr().out
    assert f"{path.name}, foreign: part 'rod' under the name of another entry, 'bar'. It is not used" in out
    assert out.count("is not used") == 1
    assert main(["cache", "--clear", "bar"]) == 0
    assert "Removed 1 parts" in capsys.readouterr().out
    assert [kept.name for kept in parts.kept_bodies()] == ["rod"]


def test_another_recipe_of_the_same_part_is_named(folder, capsys):
    heard(bar())
    path = entry(folder, "bar")
    heard(bar(length=2.0))
    (other,) = set(folder.glob("*.h5")) - {path}
    shutil.copy(other, path)
    assert main(["cache"]) == 0
    assert f"{path.name}, foreign: part 'bar' of another recipe. It is not used" in capsys.readouterr().out


def test_entries_of_other_code_are_counted(folder, capsys, monkeypatch):
    heard(bar())
    monkeypatch.setattr("flexmb.parts.body_cache.release", lambda: "another")
    assert main(["cache"]) == 0
    out = capsys.readouterr().out
    assert "1 of them, " in out
    assert "of another version of flexmb: this one does not use them" in out
    assert "is not used:" not in out


def test_a_folder_in_the_place_of_an_entry(folder, capsys):
    """The part is made and used, and told that it is not kept; listing and clearing go on."""
    heard(bar())
    path = entry(folder, "bar")
    path.unlink()
    path.mkdir()
    data, ear = heard(bar())
    assert data.mass == pytest.approx(STEEL.density * AREA, rel=1e-12)
    assert "could not be kept" in ear.troubles[0][1]
    assert main(["cache"]) == 0
    assert f"{path.name}, damaged: it is an empty folder" in capsys.readouterr().out
    assert main(["cache", "--clear"]) == 0
    assert path.is_dir()


def test_two_processes_write_one_entry(folder):
    """Both get the part, and one whole entry is left; nothing of the work in progress stays."""
    program = (
        "import sys; from parts.test_kept_by_content import bar, heard; "
        "data, ear = heard(bar()); print(ear.reduced, ear.reused, data.mass, ear.troubles)"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    both = [
        subprocess.Popen([sys.executable, "-c", program], env=environment, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    said = [process.communicate()[0].split(maxsplit=3) for process in both]
    assert sorted(line[0] for line in said) == ["0", "1"]
    assert sorted(line[1] for line in said) == ["0", "1"]
    assert np.allclose([float(line[2]) for line in said], STEEL.density * AREA, rtol=1e-12)
    assert all(line[3].strip() == "[]" for line in said)
    assert len(list(folder.iterdir())) == 1
