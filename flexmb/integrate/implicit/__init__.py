"""The implicit Runge-Kutta method in the coordinates of joints, and its compiled step."""
