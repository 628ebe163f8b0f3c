"""The compiled model: layout, evaluation, tangent, assembly, mobility."""

from flexmb.system.assembly import assemble
from flexmb.system.compile import compile
from flexmb.system.system import System

__all__ = ["System", "assemble", "compile"]
