"""Gains from a model of the machine, and the robustness of a loop with given gains."""
