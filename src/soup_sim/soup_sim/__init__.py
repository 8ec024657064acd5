"""The warehouse world: physics, stations, orders, layouts, statistics, and the node that simulates it."""
