"""Command lines, and what goes to the screen or into files."""
