"""Plans of the interfaces, found by the stem of their kind."""
