"""Pictures, animations and plots of a solution, mode shapes of a body."""

from flexmb.view.graphics import require_graphics
from flexmb.view.mode_sheet import mode_sheet
from flexmb.view.pictures import overlay, render
from flexmb.view.plots import plot

__all__ = ["mode_sheet", "overlay", "plot", "render", "require_graphics"]
