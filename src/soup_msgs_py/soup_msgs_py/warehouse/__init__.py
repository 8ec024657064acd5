"""What stands on the floor: layout, tiles, words, worlds of cells."""
