"""A platinum element behind a MAX31865, for heatwright."""

import heatwright.spec  # noqa: F401 - the language first: it is what imports the model
