"""Campaigns: many runs of one spec, each on a machine that is varied at random from a seed."""
