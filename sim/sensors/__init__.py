"""Simulated sensors, one module for each kind of the language."""
