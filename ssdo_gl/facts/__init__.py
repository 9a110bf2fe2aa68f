"""What is known of a scene and of a view before anything is drawn."""
