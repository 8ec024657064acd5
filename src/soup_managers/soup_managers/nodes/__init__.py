"""The managers as ROS nodes: shells that carry messages."""
