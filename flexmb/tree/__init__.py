"""Trees of joints: spanning tree, relative coordinates, recursive solution of linear cost."""
