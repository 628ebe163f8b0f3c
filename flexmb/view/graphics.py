"""Can this machine draw? Without an OpenGL library VTK does not raise, it crashes; so a child process tries first."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache

from flexmb.errors import FlexmbError

__all__ = ["require_graphics"]

TRIAL = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(32, 32))
plotter.add_mesh(pyvista.Sphere())
assert plotter.screenshot(None, return_img=True).std() > 0
"""


@cache
def _outcome() -> int:
    """Return the exit code of a process that draws a sphere."""
    return subprocess.run([sys.executable, "-c", TRIAL], capture_output=True, check=False).returncode


@contextmanager
def _signals_waiting() -> Iterator[None]:
    """Let Ctrl-C and a polite kill wait: an exception while its libraries are loaded crashes VTK, or leaves it without
    a part of them.
    """
    came: list[int] = []
    before = {}
    with suppress(ValueError):  # not the main thread: no handler runs in this one
        for number in (signal.SIGINT, signal.SIGTERM):
            if callable(handler := signal.getsignal(number)):
                signal.signal(number, lambda struck, frame: came.append(struck))
                before[number] = handler
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for struck in came:
            signal.raise_signal(struck)


def require_graphics() -> None:
    """Raise FlexmbError with the packages to install if nothing can be drawn off-screen; tried once per process."""
    code = _outcome()
    if code == 0:
        with _signals_waiting():
            import pyvista.plotting  # noqa: F401
    if code != 0:
        raise FlexmbError(
            "Rendering",
            found=f"a trial picture ended with code {code}",
            expected="an OpenGL library that draws without a screen (EGL or OSMesa)",
            remedy="Install it: 'apt-get install libegl1 libgl1-mesa-dri' (Debian, Ubuntu) or 'dnf install "
            "mesa-libEGL mesa-dri-drivers' (Fedora); plots and ParaView files work without it",
        )
