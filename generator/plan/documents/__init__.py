"""What a project has beside its sources, and its builder has to know."""
