"""What a bench found, as tables, plots, pictures and one HTML file."""
