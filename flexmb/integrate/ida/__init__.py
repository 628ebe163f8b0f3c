"""Backward differentiation formulas of SUNDIALS on the stabilised index-2 equations."""
