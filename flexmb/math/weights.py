"""What an evaluation shall make of the iteration matrix."""

from __future__ import annotations

from flexmb.math.kernel import kernel
from flexmb.math.structures import Record

__all__ = ["Weights", "no_matrix", "weigh", "weigh_mass"]


class Weights(Record):
    """S = [c_M M + c_D D + c_K K, -G^T; G, 0], and which parts of it are wanted."""

    mass: float
    """c_M of the mass matrix M"""
    damping: float
    """c_D of D, the derivative of the residual by the velocities"""
    stiffness: float
    """c_K of K, the derivative by the configuration"""
    half_step: float
    """s, half the step over which the increment of a method is taken"""
    wanted: int
    """1: the matrix is wanted; 0: the residual alone"""
    constrained: int
    """1: with the rows and columns of the constraints; 0: the blocks of the bodies alone"""
    world_axes: int
    """1: steps translate frames in world axes; 0: in body axes"""


@kernel
def weigh(weights, mass, damping=0.0, stiffness=0.0, half_step=0.0, constrained=1, world_axes=0):
    """Ask for the iteration matrix with these weights."""
    one = weights[0]
    one.mass, one.damping, one.stiffness, one.half_step = mass, damping, stiffness, half_step
    one.wanted, one.constrained, one.world_axes = 1, constrained, world_axes


@kernel
def weigh_mass(weights):
    """Ask for the mass matrix and the gradients; from Python, where arguments that are left out take 0.3 ms."""
    weigh(weights, 1.0)


@kernel
def no_matrix(weights):
    """Ask for no matrix; kernels that look at weights alone find zero."""
    weigh(weights, 0.0)
    weights[0].wanted = 0
