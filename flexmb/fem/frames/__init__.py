"""Straight beams and rods, and the sections that they have."""
