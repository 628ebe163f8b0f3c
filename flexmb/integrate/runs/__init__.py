"""A simulation from start to end: phases, samples, events, and what is watched meanwhile."""
