"""A text display on I²C, for heatwright."""

import heatwright.spec  # noqa: F401 - the language first: it is what imports the model
