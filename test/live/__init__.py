"""Tests with real ROS nodes in real processes."""
