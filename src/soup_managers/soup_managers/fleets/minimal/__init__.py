"""The fleet that works trip by trip, as in the first paper."""
