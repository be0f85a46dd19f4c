"""Where samples go: disks, spheres, hemispheres, noise tiles; and how occluders count with distance."""
