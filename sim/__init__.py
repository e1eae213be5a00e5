"""The simulator: processor, machine and operator, and the reference model of the firmware."""
