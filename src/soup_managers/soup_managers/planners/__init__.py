"""Joint plans for several robots in a world of cells (the paper of 2023), and what goes far beyond its limits."""
