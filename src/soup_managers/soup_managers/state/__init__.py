"""What a fleet knows: bots, jobs, stock, places, tasks. Each fact has one owner."""
