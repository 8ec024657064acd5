"""The browser page of a running warehouse."""
