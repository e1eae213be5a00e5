"""One module for each command; it imports others only when it runs, so that `--help` is quick."""
