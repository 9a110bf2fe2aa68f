"""Triangles, surfaces and emitters as tables that rays descend: plain data, no OpenGL."""
