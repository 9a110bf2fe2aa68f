"""What a rendering gives back: arrays, colours, averages, files."""
