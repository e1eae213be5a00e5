"""Simulated displays, keys and serial partners, one module for each kind of interface."""
