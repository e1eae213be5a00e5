"""Runs of one spec on many random machines, on this computer or on a cluster."""
