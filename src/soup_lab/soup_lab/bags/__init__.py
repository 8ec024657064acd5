"""rosbag2 bags: recorded, made whole, replayed, judged, run on."""
