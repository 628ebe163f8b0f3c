"""Names of files may be bytes that are no UTF-8: runs there are computed, exported and reported like others."""

import os
import sys

import pytest

import flexmb as fmb
from flexmb.cli import main

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="names of files are bytes on Linux")


def test_a_run_folder(tmp_path, capsys):
    name = os.fsdecode(bytes(tmp_path) + b"/run\xff")
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("stone", mass=1.0, velocity=(1, 0, 0))],
        sensors=[fmb.Position("place", marker="stone.center")],
    )
    fmb.save_model(model, tmp_path / "stone.toml", fmb.Simulation(t_end=0.1, samples=3))
    for command in (
        ["run", str(tmp_path / "stone.toml"), "--out", name],
        ["export", name, "--vtk"],
        ["report", name, "--no-pictures"],
    ):
        assert main(command) == 0
    capsys.readouterr()
    (index,) = [p for p in os.listdir(os.fsencode(name)) if p.endswith(b".pvd")]
    with open(os.path.join(os.fsencode(name), index), "rb") as stream:
        text = stream.read()
    first = text.partition(b'file="')[2].partition(b'"')[0]
    assert os.path.isfile(os.path.join(os.fsencode(name), first))  # as ParaView will look for it


def test_a_mark_of_the_byte_order_before_a_model_file(tmp_path):
    """Editors of Windows put it first, and end lines by two characters."""
    path = tmp_path / "model.toml"
    path.write_bytes('\ufeffname = "stone"\r\n[[body]]\r\nkind = "Ground"\r\n'.encode())
    assert fmb.load_model(path).name == "stone"


@pytest.mark.parametrize("field", ['base = "ring.toml"', 'parameters_from = [{ file = "ring.toml", table = "a" }]'])
def test_links_that_lead_in_a_circle(tmp_path, field):
    (tmp_path / "ring.toml").symlink_to("back.toml")
    (tmp_path / "back.toml").symlink_to("ring.toml")
    path = tmp_path / "model.toml"
    path.write_text(f'{field}\n[[body]]\nkind = "Ground"\n')
    with pytest.raises(fmb.FlexmbError, match=r"ring\.toml"):
        fmb.load_model(path)
    path.write_text('[[body]]\nkind = "FloatingBody"\nname = "f"\ndata = "ring.toml"\n')
    with pytest.raises(fmb.FlexmbError, match=r"ring\.toml"):
        fmb.load_model(path)
