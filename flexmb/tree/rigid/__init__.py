"""The recursion over rigid links in their own axes: the passes, closed loops, motion and projection."""
