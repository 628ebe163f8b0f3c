"""How far two ways to compute one thing may lie apart, relative to the largest value of its kind."""

from __future__ import annotations

LIMITS = {
    # equations that are linear in accelerations: rounding, grown by the worst conditioned cable
    "Augmented": 1e-6,
    "NullSpace": 1e-6,
    "UdwadiaPhohomsiri": 1e-6,
    "tree": 1e-6,
    # eigenvalues near critical damping grow rounding by its root
    "linearize": 1e-4,
    # an iteration that ends at unbalanced forces of 1e-9, in softness of up to 1e3
    "statics": 1e-4,
    # constraints satisfied to 1e-11, then linear equations
    "kinematics": 1e-6,
    # equal steps: the tolerance of Newton's iteration
    "steps": 1e-4,
    # other steps for other rounding: what these tolerances leave after 0.1 s
    "GeneralizedAlpha": 2e-3,
    "adaptive": 2e-3,
    "IDA": 1e-3,
    "Explicit": 1e-3,
    "Implicit": 1e-3,
    "Recursive": 1e-3,
    "elastic": 2e-3,
    "stiff": 1e-3,
}
KINDS_FOR = {
    # bodies with a frame, and points
    "tree": ("rigid", "point", "reduced"),
    "Implicit": ("rigid", "point"),
    # steps that resolve the vibrations of bars would take minutes
    "Recursive": ("rigid", "point"),
    "elastic": ("rigid", "reduced", "beam"),
    "stiff": ("rigid", "point", "reduced"),
    "adaptive": ("rigid", "point"),
    "Explicit": ("rigid", "point", "cable"),
}
"""Bodies for analyses that do not take all, or not in a reasonable time."""
