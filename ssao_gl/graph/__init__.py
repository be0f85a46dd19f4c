"""The frame graph: textures, passes and draws declared as data, and compiled to plans. Knows nothing of OpenGL."""
