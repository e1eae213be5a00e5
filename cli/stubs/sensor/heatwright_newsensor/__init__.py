"""A newsensor, for heatwright."""

import heatwright.spec  # noqa: F401 - the language first: it is what imports the model
