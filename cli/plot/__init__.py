"""Readings of a loop from a serial line, or from a recorded log."""
