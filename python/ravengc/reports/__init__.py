"""What came out of a run, as numbers and as pictures."""
