"""The force library: one kind per file, one import line per kind."""

from flexmb.forces.point_load import PointLoad
from flexmb.forces.spring_damper import SpringDamper

KINDS = {kind.__name__: kind for kind in (SpringDamper, PointLoad)}
"""All forces by name: read by the model files, the contract tests and the reference pages."""

__all__ = ["KINDS", *KINDS]
