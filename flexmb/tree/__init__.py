"""Trees of joints: spanning tree, recursive solution of linear cost, relative coordinates, loops by cut joints."""

from flexmb.tree.coordinates.centroid import Centroid
from flexmb.tree.coordinates.joint_tree import JointTree
from flexmb.tree.coordinates.relative_state import RelativeState
from flexmb.tree.recursive import Recursive
from flexmb.tree.spanning import Spanning, spanning_tree

__all__ = ["Centroid", "JointTree", "Recursive", "RelativeState", "Spanning", "spanning_tree"]
