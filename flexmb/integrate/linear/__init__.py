"""Linear equations about a state: frequencies, modes, inputs and outputs."""
