"""Shaders of the tests."""
