"""The files that a project has beside its sources, and the documents for the machine's builder."""
