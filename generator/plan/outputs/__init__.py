"""Plans of the outputs; each module has the name of its kind."""
