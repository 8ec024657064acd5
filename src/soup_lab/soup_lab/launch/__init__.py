"""A live warehouse: its processes started, kept running, ended."""
