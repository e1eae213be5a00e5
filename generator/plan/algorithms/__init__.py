"""Plans of the algorithms; each module has the name of its kind."""
