"""The parts of the specs that `heatwright init` writes."""
