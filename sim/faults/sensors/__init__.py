"""The faults of each kind of sensor, one module for each kind."""
