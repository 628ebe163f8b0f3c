"""The recursion over bodies of any kind: inertias from the leaves to the roots, accelerations back."""
