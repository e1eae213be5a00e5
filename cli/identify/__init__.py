"""Output of `heatwright identify`: YAML, JSON and a figure."""
