"""The shared language of the warehouse: what its parts say to each other, in plain Python."""
