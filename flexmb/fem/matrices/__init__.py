"""Stiffness and mass matrices of other programs: one reader per format, and checks."""
