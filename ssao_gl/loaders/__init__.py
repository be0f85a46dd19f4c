"""Foreign scene and camera formats. Each module imports its library only when it is used."""
