"""Every mesh file of some folders, beside trimesh: ``python -m tests.robustness.bulk_models FOLDER ...``

What both read must have as many triangles; what is refused must be refused in one line. Exits with 1 where it is not so.
"""

from __future__ import annotations

import collections
import logging
import sys
from pathlib import Path

import trimesh

import ssao_gl as ao
from ssao_gl.loaders.mesh_files import formats, kind_of


def theirs(path: Path) -> int | None:
    """Triangles that trimesh finds, instances counted each; None when it does not read the file."""
    try:
        scene = trimesh.load_scene(path, process=False)
        parts = [scene.geometry[scene.graph[node][1]] for node in scene.graph.nodes_geometry]
        return sum(len(part.faces) for part in parts if isinstance(part, trimesh.Trimesh))
    except BaseException:
        return None


def main(folders: list[str]) -> int:
    logging.disable(logging.CRITICAL)
    counts: collections.Counter[str] = collections.Counter()
    for path in sorted(path for folder in folders for path in Path(folder).rglob("*") if path.is_file()):
        if kind_of(path.name) not in formats():
            continue
        expected = theirs(path)
        try:
            found: int | None = ao.load_scene(path).triangles
        except ao.SsaoError as error:
            found = None
            wrong = "\n" in str(error)
            counts["not one line" if wrong else "refused, read by trimesh" if expected else "refused by both"] += 1
            if wrong or expected:
                print(f"{path.name}: trimesh {expected}; {error}")
        except BaseException as error:
            found = None
            counts["traceback"] += 1
            print(f"{path.name}: {type(error).__name__} {error}")
        if found is not None:
            verdict = "read, not by trimesh" if not expected else "same" if found == expected else "other triangles"
            counts[verdict] += 1
            if verdict == "other triangles":
                print(f"{path.name}: trimesh {expected}, here {found}")
    print(", ".join(f"{number} {verdict}" for verdict, number in sorted(counts.items())))
    return 1 if counts["traceback"] or counts["not one line"] else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
