"""The word and the letter manager: stations to fill, jobs to have done."""
