"""The files that a project has beside its sources, and what its builder has to know."""
