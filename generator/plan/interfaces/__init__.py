"""Plans of the interfaces; each module has the name of its kind."""
