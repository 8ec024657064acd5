"""The live graph: processes, services, actions and followers of the world, around minds that know no ROS."""
