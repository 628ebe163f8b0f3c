"""What two surfaces that are near each other do to each other."""

from __future__ import annotations

from flexmb.forces.contact_wrench import act_at_contact
from flexmb.forces.relative import act_relative, relative_motion
from flexmb.math.kernel import kernel
from flexmb.surfaces.detection import find_areas, find_closest

__all__ = ["press_surfaces"]


@kernel
def press_surfaces(row, data, a, b, at_a, at_b, wanted, contacts, motion, Q, f, K, C, energy):
    """Let surfaces of the markers a and b press on each other; return if they touch.

    Writes the relative motion (9,) and axes Q (3, 3), and where they touch the wrench f (6,) and, if wanted, its
    derivatives K and C (6, 6), all in the axes of a.
    """
    relative_motion(a, b, motion, Q)
    if row.law == 0:
        count = find_areas(data, at_a, at_b, 0.0, motion[0:3], Q, contacts)
    else:
        count = find_closest(data, at_a, at_b, 0.0, motion[0:3], Q, contacts)
    if count == 0:
        return False
    f[:] = 0.0
    K[:] = 0.0
    C[:] = 0.0
    for c in range(count):
        act_at_contact(row, contacts[c], motion, wanted, f, K, C, energy)
    act_relative(a, b, f)
    return True
