"""One bucketbot's mind, its steering, and the crew that runs many of them in one process."""
