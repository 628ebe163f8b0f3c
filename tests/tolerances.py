"""The two tolerances of the test-suite; a third one belongs to the reference case that states it.

Import with ``from tolerances import MACHINE, SOLVER``.
"""

MACHINE = 1e-12
"""Equal up to rounding: the same formula, evaluated in another order (relative to the largest entry)."""

SOLVER = 1e-6
"""Equal up to an iteration or an error-controlled integration run at its tight setting."""
