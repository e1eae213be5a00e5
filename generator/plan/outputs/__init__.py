"""Plans of the outputs, found by the stem of their kind."""
