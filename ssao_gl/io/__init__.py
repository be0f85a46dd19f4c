"""Files: outputs that appear whole or not at all, locks, caches, fingerprints, pictures and arrays."""
