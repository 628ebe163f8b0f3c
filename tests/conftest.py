"""What every test may use: seeded random numbers, reference cases, outside programs."""

from __future__ import annotations

import gc
import getpass
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

# One BLAS thread: two threads on small matrices cost more than they bring. Set before numpy is loaded.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
os.environ["FLEXMB_QUIET"] = "1"  # what a test prints does not depend on what is compiled already

# Parts of model files are kept apart from those of the user, and from one run of the tests to the next.
os.environ.setdefault("FLEXMB_BODIES", str(Path(tempfile.gettempdir()) / f"flexmb-test-bodies-{getpass.getuser()}"))

import numpy as np
import pytest
from rewritten import rewrite_own_share
from spent import Spent

# A shell starts background jobs with Ctrl-C ignored, and children inherit that: the tests of interruption need it.
signal.signal(signal.SIGINT, signal.default_int_handler)

VALIDATION = Path(__file__).parent / "data" / "validation"

DRAW_ONE_SPHERE = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(40, 40))
plotter.add_mesh(pyvista.Sphere())
assert plotter.screenshot(None, return_img=True).std() > 0
"""


def pytest_addoption(parser):
    parser.addoption("--seed", type=int, default=1, help="seed of the random models and states (default: 1)")


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config):
    """Run the whole suite on all cores; single files and folders, or what -n says, as they are asked for."""
    options = config.option
    if "PYTEST_XDIST_WORKER" in os.environ:  # one of them: it must not start others
        return
    whole = config.args_source is pytest.Config.ArgsSource.TESTPATHS
    watched = options.collectonly or options.usepdb
    if whole and not watched and config.pluginmanager.hasplugin("xdist") and options.numprocesses is None:
        options.numprocesses = "auto"
        options.dist = "worksteal" if options.dist == "no" else options.dist


def pytest_configure(config):
    os.environ.setdefault("FLEXMB_AHEAD", "0")  # the workers have the cores
    config.pluginmanager.register(Spent(), "spent")


def pytest_sessionstart(session):
    """Compile all kernels once, in shares, before workers begin: each would compile the same ones in an empty cache."""
    if "PYTEST_XDIST_WORKER" in os.environ or not getattr(session.config.option, "numprocesses", None):
        return
    if os.environ.get("FLEXMB_WARM") == "0":  # whoever starts the tests has done it
        return
    content = hashlib.sha256()
    for path in sorted((Path(__file__).parents[1] / "flexmb").rglob("*.py")):
        content.update(path.read_bytes())
    from flexmb.math.kernel_cache import kernel_folder

    done = kernel_folder() / f"warm-{content.hexdigest()[:20]}"
    if not done.exists():
        command = [sys.executable, "-m", "flexmb", "warm", "--jobs", str(session.config.option.numprocesses)]
        if subprocess.run(command, check=False).returncode == 0:
            done.parent.mkdir(parents=True, exist_ok=True)
            done.touch()


@pytest.hookimpl(wrapper=True)
def pytest_collection(session):
    """Search no garbage while tests are collected, nor later among them: they stay to the end (a fifth of the time)."""
    gc.disable()
    try:
        rewrite_own_share(session.config)
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


def pytest_report_header(config) -> str:
    return f"random models and states: --seed {config.getoption('seed')}"


@pytest.fixture
def rng(request) -> np.random.Generator:
    """Random numbers of one seed for all tests: the same in any order, under any name, alone or with others."""
    return np.random.default_rng(request.config.getoption("seed"))


@pytest.fixture(scope="session")
def reference():
    """``reference("RB01")`` is the reference case of that id: its JSON file as a dict."""

    def load(case_id: str) -> dict:
        return json.loads((VALIDATION / f"{case_id}.json").read_text())

    return load


def _absent(reason: str) -> None:
    """Skip the test on a user's machine; where everything must be proved (CI is set), what is missing is a failure."""
    (pytest.fail if "CI" in os.environ else pytest.skip)(reason)


@pytest.fixture(scope="session")
def ccx() -> str:
    """Path of CalculiX, the outside FE program; the test is skipped where it is not installed."""
    path = shutil.which("ccx")
    if path is None:
        _absent("CalculiX (ccx) is not installed; on Debian: apt-get install calculix-ccx")
    return path


@cache
def can_render() -> bool:
    """Draw in a child process: without an OpenGL library VTK does not raise, it crashes."""
    child = subprocess.run([sys.executable, "-c", DRAW_ONE_SPHERE], capture_output=True, check=False)
    return child.returncode == 0


def pytest_runtest_setup(item):
    if item.get_closest_marker("render") and not can_render():
        _absent("no off-screen OpenGL library; on Debian: apt-get install libegl1 libgl1")
