"""Joint coordinates: what the joints of a tree let move, and the way to the state of the bodies and back."""
