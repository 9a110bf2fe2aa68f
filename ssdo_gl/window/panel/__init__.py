"""The panel over the picture: every setting, lights, times and reasons."""
