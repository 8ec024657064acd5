"""Joint plans for worlds of cells, shown."""
