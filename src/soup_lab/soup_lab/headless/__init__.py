"""A whole warehouse in one process: one run, or many with independent seeds."""
