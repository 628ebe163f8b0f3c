"""Trees of joints: spanning tree, recursive solution of linear cost, loops by cut joints."""

from flexmb.tree.recursive import Recursive
from flexmb.tree.spanning import Spanning, spanning_tree

__all__ = ["Recursive", "Spanning", "spanning_tree"]
