"""The commands: the only place where generator and simulation meet."""
