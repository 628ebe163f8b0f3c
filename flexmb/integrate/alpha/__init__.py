"""The generalized-alpha method: the integrator and its compiled step."""
