"""Rigid contact with Coulomb friction: impulses of contact by complementarity, and time stepping over impacts."""
