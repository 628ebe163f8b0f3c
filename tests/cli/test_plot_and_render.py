"""`flexmb plot` and `flexmb render`: pictures of a run folder."""

from pathlib import Path

import numpy as np
import pytest

from flexmb.cli import main


@pytest.fixture
def run(fall, capsys):
    """The run folder "one" of a falling mass."""
    assert main(["run", "fall.toml", "--out", "one"]) == 0
    capsys.readouterr()
    return Path("one")


def test_plot(run, capsys):
    assert main(["plot", "one", "place", "-o", "out/place.svg"]) == 0
    assert "Plot: out/place.svg" in capsys.readouterr().out
    assert "<svg" in Path("out/place.svg").read_text(encoding="utf-8")
    assert main(["plot", "one", "place"]) == 0
    assert (run / "place.png").stat().st_size > 5000
    assert main(["plot", "one"]) == 0
    assert (run / "sensors.png").is_file()


def test_plot_over_another_sensor(run, capsys):
    """One sensor over another, beside another run, divided; the report shows the same diagram."""
    assert main(["run", "fall.toml", "--set", "g=1.62", "--out", "two"]) == 0
    over = ["--over", "place x", "--with", "two", "--per", "2", "-o", "path.png"]
    assert main(["plot", "one", "place z", *over]) == 0
    assert Path("path.png").stat().st_size > 5000
    page = ["--no-pictures", "--diagram", "path = place z over place x / place z at 1", "-o", "both.html"]
    assert main(["report", "one", "two", *page]) == 0
    assert "<h2>Diagrams</h2>" in Path("both.html").read_text(encoding="utf-8")
    capsys.readouterr()
    assert main(["plot", "one", "place z", "--over", "plac x"]) == 2
    assert "Did you mean 'place x'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["plot", "one", "plac"], "Did you mean 'place'?"),
        (["plot", "one", "place", "-o", "x.bmp"], "the ending '.bmp'"),
        (["plot", "two"], "Run folder 'two': it does not exist"),
        (["view", "two"], "Run folder 'two': it does not exist"),
        (["view", "one", "--size", "big"], "--size big: 'big'. Expected: 2 numbers"),
        (["render", "two"], "Run folder 'two': it does not exist"),
        (["render", "one", "-o", "x.bmp"], "the ending '.bmp'"),
        (
            ["render", "one", "--size", "0x10"],
            "--size 0x10: '0x10'. Expected: 2 numbers separated by 'x'. Write --size",
        ),
        (
            ["render", "one", "--camera", "1,2"],
            "--camera 1,2: '1,2'. Expected: 3 numbers separated by ','. Write --camera",
        ),
    ],
)
def test_messages(run, arguments, message, capsys):
    assert main(arguments) == 2
    assert message in capsys.readouterr().err


@pytest.mark.render
def test_render(run, capsys):
    import pyvista

    assert main(["render", "one", "--size", "160x90", "--time", "0.5", "--camera", "0,-1,0.2"]) == 0
    assert "Picture: one/one.png" in capsys.readouterr().out
    image = pyvista.read(run / "one.png").point_data.active_scalars
    assert len(image) == 160 * 90
    several = ["--time", "0", "--time", "0.5", "--time", "1", "-o", "several.png"]
    assert main(["render", "one", "--size", "160x90", *several]) == 0
    assert Path("several.png").is_file()


@pytest.mark.render
def test_animation(run):
    import imageio.v2 as imageio

    assert main(["render", "one", "--size", "160x90", "-o", "fall.gif"]) == 0
    frames = imageio.mimread("fall.gif")
    assert 1 < len(frames) <= 11  # equal pictures are one picture that lasts longer
    assert np.asarray(frames[0]).shape[:2] == (90, 160)
