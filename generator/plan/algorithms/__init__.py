"""Plans of the algorithms, found by the stem of their kind."""
