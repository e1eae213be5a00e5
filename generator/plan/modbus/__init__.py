"""Outputs from the register map: the firmware's C, and the documents for its master."""
