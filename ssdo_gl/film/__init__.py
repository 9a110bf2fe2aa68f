"""Camera paths and the files of films: what the window and the command share."""
