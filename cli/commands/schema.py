"""`heatwright schema`: the language, for editors."""
