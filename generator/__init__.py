"""heatwright.generator."""
