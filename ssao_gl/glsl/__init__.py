"""Shader texts: assembled from files, includes and defines, for every dialect. No OpenGL here."""
