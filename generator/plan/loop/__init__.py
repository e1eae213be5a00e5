"""A control loop: its control step, put together from its features."""
