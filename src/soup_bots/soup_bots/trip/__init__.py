"""What one bucketbot does: trips step by step, drives along a route."""
