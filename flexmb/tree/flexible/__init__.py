"""Flexible links of the compiled recursion: their shapes, inertia, passes and loops."""
