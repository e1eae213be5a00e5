"""The bench: the unmodified firmware runs in a simulated board, on a page in the browser."""
