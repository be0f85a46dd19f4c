"""Ambient-occlusion methods: each is one settings record here and one shader in ``shaders/methods``.

A method registers itself; the command line, the report and the tests find it in :func:`.registry.registry`. Other packages
add theirs by the entry-point group ``ssao_gl.methods``.
"""
