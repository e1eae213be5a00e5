"""Runs several methods of tuning, and shows them as a table, a figure and YAML."""
