"""Simulated displays, keys and lines, one module for each kind of the language."""
