"""Plans of the sensors, found by the stem of their kind."""
