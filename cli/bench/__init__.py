"""The live bench: the unmodified firmware in its simulated board, on a page in the browser."""
