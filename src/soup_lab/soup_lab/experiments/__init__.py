"""Experiments: policies compared over scenarios and seeds."""
