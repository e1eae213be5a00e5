"""The rows of a comparison: run, tabled, drawn."""
