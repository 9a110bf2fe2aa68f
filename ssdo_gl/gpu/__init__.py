"""How the program talks to OpenGL: contexts, shaders, textures, triangles. Knows no lighting."""
