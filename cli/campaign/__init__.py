"""Many drawn machines of one spec: on this one, or on a cluster."""
