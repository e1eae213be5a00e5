"""Plans of the sensors; each module has the name of its kind."""
