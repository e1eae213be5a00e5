"""The faults of each kind of sensor that has its own; those of `sensing` serve the others."""
