"""The compiled pipeline outside Python: as JSON, for WebGL2, for native GLES 3."""
