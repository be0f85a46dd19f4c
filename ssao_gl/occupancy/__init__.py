"""What fills a scene: occupancy and opacity on a grid of voxels, whatever the scene is made of."""
