"""The touch display: the contents of its components, and the documents for its editor."""
