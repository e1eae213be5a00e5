"""What `heatwright identify` prints and draws."""
