"""Simulated sensors, one module for each kind of sensor, or for several."""
