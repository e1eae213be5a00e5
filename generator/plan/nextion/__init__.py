"""The touch display: what its components show, and the documents for its editor."""
