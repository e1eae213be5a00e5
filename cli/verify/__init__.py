"""Gathers, judges and shows the evidence for one spec."""
