"""Compiled and small data structures that know no warehouse."""
