"""The evidence for one spec: gathered, judged, shown."""
