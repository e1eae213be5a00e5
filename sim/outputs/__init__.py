"""Simulated outputs, one module for each kind of the language."""
