class Unusable(ValueError):
    """A log from which no plant can be found; the text says why, and what to do about it."""
