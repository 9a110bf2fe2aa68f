"""The fly-through far from its machine: as a session of events and pictures, and in a browser."""
