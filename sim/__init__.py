"""heatwright.sim."""
