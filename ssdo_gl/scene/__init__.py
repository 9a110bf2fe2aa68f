"""What is drawn, as plain data without OpenGL: geometry, materials, lights, camera, files."""
