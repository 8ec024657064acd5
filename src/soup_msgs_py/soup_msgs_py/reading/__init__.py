"""Files that a person wrote, read within limits; whatever is wrong is told with file and key."""
