"""The reduced elastic body in a floating frame: inertia, geometric stiffness, markers, limits."""
