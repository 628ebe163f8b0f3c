"""The compiled model: layout, evaluation, tangent, assembly, mobility."""

from flexmb.system.assembly import assemble
from flexmb.system.compile import compile
from flexmb.system.mobility import Mobility, mobility
from flexmb.system.observe import Observation, observe
from flexmb.system.openings import assemble_as_drawn
from flexmb.system.system import System

__all__ = ["Mobility", "Observation", "System", "assemble", "assemble_as_drawn", "compile", "mobility", "observe"]
