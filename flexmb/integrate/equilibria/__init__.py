"""Equilibria: of one load, and along a load that grows."""
