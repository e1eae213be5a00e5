"""heatwright.cli."""
