"""What any process of the live graph is made of, around minds that know no ROS."""
