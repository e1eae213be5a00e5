"""How each kind of sensor fails by itself, one module for each kind of the language."""
