"""`window`: a solution on the screen, to be turned, and moved through time."""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.io.scene import Scene
from flexmb.view.graphics import require_graphics
from flexmb.view.pictures import largest_stress, upwards
from flexmb.view.stage import Stage

__all__ = ["KEYS", "window"]

KEYS = "Space: play and stop. Left, right: one sample. Home, End: first and last. Mouse: turn, move, zoom. Q: close"
INTERVAL = 40  # ms between two pictures of the motion


class _Player:
    """Shows one frame after the other, by slider, keys and clock."""

    def __init__(self, stage: Stage, duration: float):
        self.stage, self.frame, self.playing = stage, 0, False
        times = stage.scene.times
        self.span, self.first, self.rate = times[-1] - times[0], times[0], (times[-1] - times[0]) / duration
        self.slider: Any = None

    def to_time(self, t: float) -> None:
        """Show the sample nearest to a time, s."""
        self.to_frame(self.stage.scene.nearest(t))

    def to_frame(self, frame: int) -> None:
        """Show a sample; the slider follows."""
        frame = int(np.clip(frame, 0, len(self.stage.scene.times) - 1))
        if frame != self.frame:
            self.frame = frame
            self.stage.move_to(frame)
        if self.slider is not None:
            self.slider.GetRepresentation().SetValue(float(self.stage.scene.times[frame]))
        self.stage.plotter.render()

    def start_or_stop(self) -> None:
        """Play from here, or from the start if the end is reached; stop if it is playing."""
        self.playing = not self.playing
        if self.playing and self.frame == len(self.stage.scene.times) - 1:
            self.to_frame(0)
        self.time = float(self.stage.scene.times[self.frame])

    def tick(self, step: int = 0) -> None:
        """Go on by the time between two pictures."""
        if not self.playing:
            return
        self.time += 1e-3 * INTERVAL * self.rate
        self.to_time(self.time)
        self.playing = self.time < self.first + self.span

    def equip(self) -> None:
        """Give the window its slider, keys and clock."""
        plotter, last = self.stage.plotter, len(self.stage.scene.times) - 1
        if last:
            self.slider = plotter.add_slider_widget(
                self.to_time,
                (self.first, self.first + self.span),
                value=self.first,
                title="time [s]",
                pointa=(0.05, 0.94),
                pointb=(0.45, 0.94),
                style="modern",
                color="#26303a",
                fmt="%.3f",
            )
        for key, action in {
            "space": self.start_or_stop,
            "Right": lambda: self.to_frame(self.frame + 1),
            "Left": lambda: self.to_frame(self.frame - 1),
            "Home": lambda: self.to_frame(0),
            "End": lambda: self.to_frame(last),
        }.items():
            plotter.add_key_event(key, action)


def window(solution, *, camera=None, size=(1600, 900), scale: float = 1.0, duration: float = 5.0) -> None:
    """Open a window with the motion: a slider for the time, the mouse to turn; returns when it is closed.

    Parameters
    ----------
    solution : Solution
        With its model.
    camera : (3,) or pyvista camera position, optional
        Direction to look from.
    size : (int, int)
        Pixels.
    scale : float
        Factor on elastic displacements.
    duration : float, s
        How long the whole motion plays.

    Raises
    ------
    FlexmbError
        There is no screen, or nothing can be drawn on this machine.
    """
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise FlexmbError(
            "Window",
            found="there is no screen (DISPLAY is not set)",
            expected="a desktop, or ssh -X",
            remedy="Draw without one: flexmb render RUN -o motion.gif, or flexmb export RUN for ParaView",
        )
    require_graphics()
    stage, player = opened(solution, camera, size, scale, duration, shown=True)
    try:
        stage.plotter.add_timer_event(max_steps=10**9, duration=INTERVAL, callback=player.tick)
        stage.plotter.show(title=f"flexmb: {solution.model.name}", auto_close=False)
    finally:
        stage.close()


def opened(solution, camera, size, scale: float, duration: float, *, shown: bool) -> tuple[Stage, _Player]:
    """Return the stage at the first sample, and what moves it."""
    scene = Scene(solution)
    frames = list(range(len(scene.times)))
    stage = Stage(scene, size, largest_stress(scene, frames), scale, shown)
    stage.add_state(0)
    stage.look_from(camera, upwards(solution.model), frames)
    player = _Player(stage, duration)
    player.equip()
    return stage, player
