"""How the camera moves: flight, recorded paths, bookmarks, collisions."""
