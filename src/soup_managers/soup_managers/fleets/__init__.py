"""The fleets: what each does with the tasks of the other managers, and what they have in common."""
