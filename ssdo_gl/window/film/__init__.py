"""A recorded camera path rendered to a file."""
