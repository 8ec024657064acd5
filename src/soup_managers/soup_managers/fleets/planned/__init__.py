"""The fleet that carries out one plan for all bots, as in the second paper."""
