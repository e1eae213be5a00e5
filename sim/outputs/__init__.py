"""Simulated outputs, one module for each kind of output, or for several."""
