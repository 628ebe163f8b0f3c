"""Links between nodes: rigid and averaging links, masses, springs, supports."""
