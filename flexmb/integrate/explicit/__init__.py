"""Explicit Runge-Kutta methods: by SciPy and as compiled steps, with projection."""
