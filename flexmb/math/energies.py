"""What an evaluation adds up over all parts: energies, and the powers of what is not in them."""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.math.structures import Record

__all__ = ["Energy", "clear_energy", "powers", "stored_energies", "write_powers"]


class Energy(Record):
    """Energies, J, and powers, W."""

    kinetic: float
    strain: float
    """of deformation of the bodies"""
    potential: float
    """of gravity and springs"""
    load_power: float
    drive_power: float
    dissipation: float


@kernel
def clear_energy(energy):
    """Set all to zero."""
    one = energy[0]
    one.kinetic = one.strain = one.potential = 0.0
    one.load_power = one.drive_power = one.dissipation = 0.0


@kernel
def stored_energies(energy):
    """Return kinetic, strain and potential energy (3,), J."""
    one, found = energy[0], np.empty(3)
    found[0], found[1], found[2] = one.kinetic, one.strain, one.potential
    return found


@kernel
def write_powers(energy, out):
    """Write the powers of loads, of drives and of dissipation to `out` (3,), W."""
    one = energy[0]
    out[0] = one.load_power
    out[1] = one.drive_power
    out[2] = one.dissipation


@kernel
def powers(energy):
    """Return the powers of loads, of drives and of dissipation (3,), W."""
    found = np.empty(3)
    write_powers(energy, found)
    return found
