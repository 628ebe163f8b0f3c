"""Cables and beams in absolute nodal coordinates: curves, sections, elements and their kernels."""
