"""A newsensor, for heatwright."""

import heatwright.spec  # noqa: F401 - import the language first: it imports the model
