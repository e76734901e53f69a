"""Makes configurations: where beads and molecules stand at the start."""
