"""Gains from a model of the machine, and how robust a loop with given gains is."""
