"""Speeds, where they belong: tests never assert a time."""
