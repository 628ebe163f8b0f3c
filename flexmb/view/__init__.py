"""Pictures, animations and plots of a solution."""

from flexmb.view.graphics import require_graphics
from flexmb.view.pictures import overlay, render
from flexmb.view.plots import plot

__all__ = ["overlay", "plot", "render", "require_graphics"]
