"""Methods of tuning side by side: run, tabled, drawn, written as YAML."""
