class Unusable(ValueError):
    """A log no plant can be told from; the text says why, and what to do about it."""
