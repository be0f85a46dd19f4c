"""From settings to plans: which passes a frame has, what is left out of it and why. No OpenGL here."""
