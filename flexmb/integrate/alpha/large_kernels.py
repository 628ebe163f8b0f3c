"""The large kernels of the generalized-alpha method, which several processes share where they are missing."""

from flexmb.integrate.alpha.corrected import follow, local_errors
from flexmb.integrate.alpha.step_size import fit_to_step, write_sample
from flexmb.integrate.runs.energy_watch import energies_of_samples
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve
from flexmb.math.jets import sample_signals

__all__ = ["LARGE_KERNELS"]

LARGE_KERNELS = (
    sample_signals,
    lu_factor,
    lu_solve,
    local_errors,
    follow,
    energies_of_samples,
    write_sample,
    fit_to_step,
)
"""First what setting up needs, then what `run_steps` calls last: its own process begins with what it calls first."""
