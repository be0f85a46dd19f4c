"""Pictures too large for one texture: cut into tiles, drawn one by one, put together on disk."""
