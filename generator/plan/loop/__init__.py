"""A control loop: what its features make of its step."""
