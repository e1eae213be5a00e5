"""heatwright.templates."""
