"""Many machines of one spec, each drawn from a seed, and what becomes of each."""
