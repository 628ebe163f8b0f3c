"""The bodies: one kind per file, one import line per kind."""

from flexmb.bodies.floating.floating_body import FloatingBody
from flexmb.bodies.ground import Ground
from flexmb.bodies.line.ancf_beam import AncfBeam
from flexmb.bodies.line.ancf_cable import AncfCable
from flexmb.bodies.plate.ancf_plate import AncfPlate
from flexmb.bodies.point_mass import PointMass
from flexmb.bodies.rigid import RigidBody
from flexmb.bodies.shape import VALUES as SHAPES
from flexmb.bodies.shape import Ball, Box, Extrusion, Tube
from flexmb.model.kinds import Body
from flexmb.model.registered import registered
from flexmb.model.skin import Skin

KINDS = registered(globals(), Body)
"""All bodies by name: read by the model files, the contract tests and the reference pages."""
VALUES = {**SHAPES, "Skin": Skin}
"""Values of their fields, for model files."""

__all__ = ["KINDS", *KINDS, "VALUES", "Ball", "Box", "Extrusion", "Skin", "Tube"]
