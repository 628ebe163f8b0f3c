"""Flat shell elements and layups: membrane, bending, shear."""
