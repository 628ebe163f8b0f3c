"""Plates and shells in absolute nodal coordinates: surfaces, elements and their kernels."""
