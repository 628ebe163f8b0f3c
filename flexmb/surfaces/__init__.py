"""Surfaces that can touch: one shape per file, one import line per shape."""

from flexmb.model.part import Part
from flexmb.model.registered import registered
from flexmb.surfaces.capsule import Capsule
from flexmb.surfaces.cuboid import Cuboid
from flexmb.surfaces.cylinder import Cylinder
from flexmb.surfaces.extruded_profile import ExtrudedProfile
from flexmb.surfaces.height_field import HeightField
from flexmb.surfaces.plane import Plane
from flexmb.surfaces.revolved_profile import Cone, RevolvedProfile, Torus
from flexmb.surfaces.shape import Shape
from flexmb.surfaces.skin_surface import SkinSurface
from flexmb.surfaces.sphere import Sphere
from flexmb.surfaces.surface import Surface
from flexmb.surfaces.triangle_mesh import Hull, TriangleMesh

KINDS = registered(globals(), Part)
"""All surfaces by name: read by the model files, the contract tests and the reference pages."""
VALUES = registered(globals(), Shape)
"""All shapes by name, for model files: ``shape = { kind = "Sphere", radius = 0.1 }``."""

__all__ = ["KINDS", "VALUES", *KINDS, *VALUES]
