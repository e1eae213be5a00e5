"""What becomes of the register map: the C of the firmware, and what its master is given."""
