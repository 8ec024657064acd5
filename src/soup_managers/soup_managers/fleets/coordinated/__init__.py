"""Coordination leg by leg: bots, buckets and stations are matched at the latest moment, on a reservation table."""
