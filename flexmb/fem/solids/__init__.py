"""Solid elements: shape functions, matrices and stresses."""
