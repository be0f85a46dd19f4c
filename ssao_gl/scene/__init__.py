"""What is drawn: meshes, cameras, projections, and a scene of our own."""
