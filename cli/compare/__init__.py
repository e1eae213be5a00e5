"""Runs the rows of a comparison, and shows them as a table and as figures."""
