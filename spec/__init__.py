"""heatwright.spec."""
