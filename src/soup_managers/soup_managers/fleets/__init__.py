"""The fleets: what each does with the tasks of the other managers, and what they have in common.

The default fleet is `coordinated`; `make` makes the one that a policies file names.
"""
