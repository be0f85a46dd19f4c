"""Visibility as occlusion textures of a glTF file (glTF 2.0, 3.9.3): which primitives share one, and where it is written."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ..errors import SceneError
from ..loaders.gltf_accessors import raw, values
from ..loaders.gltf_document import Document, Tree
from ..loaders.gltf_draco import DRACO
from ..loaders.gltf_writing import INDICES, GltfWriter
from .atlas import Unwrapped, unwrap
from .facets import Facets
from .primitives import Primitive
from .settings import OcclusionTexture
from .texels import TexelPlaces, TextureLayout, texels

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
OVERLAP = 1e-3
"""Share of a texture's points that two triangles may claim: rounding along seams."""
VARIANTS = "KHR_materials_variants"
SET = "TEXCOORD_"


@dataclass(frozen=True, eq=False)
class TextureGroup:
    """Primitives that share a texture: its places, the coordinate set of each primitive, and new vertices where it has any."""

    name: str
    places: TexelPlaces
    sets: Sequence[int]
    unwrapped: Sequence[Unwrapped | None]

    @property
    def primitives(self) -> Sequence[Primitive]:
        """Those that share it."""
        return self.places.layout.primitives


def texture_groups(
    writer: GltfWriter, document: Document, facets: Facets, primitives: Sequence[Primitive], to: OcclusionTexture, seed: int
) -> list[TextureGroup]:
    """Return the textures that are needed: one for each material whose coordinates do not overlap, one for all the rest.

    Raises SettingsError, SceneError.
    """
    shown = [primitive for primitive in primitives if primitive.parts]
    groups, rest = [], []
    for material, members in _by_material(writer.tree, shown):
        found = _own_coordinates(writer.tree, document, facets, members, to, seed) if material is not None else None
        if found is None:
            rest += members
        else:
            groups.append(found)
    if rest:
        if to.unwrap == "never":
            raise SceneError(
                f"mesh '{rest[0].name}' has no texture coordinates in 0..1 that do not overlap; leave out --unwrap never, or bake to vertices"
            )
        groups.append(_atlas_group(writer, document, facets, rest, to, seed))
    return groups


def _by_material(tree: Tree, primitives: Sequence[Primitive]) -> Iterator[tuple[int | None, list[Primitive]]]:
    """Primitives of each material. None: those of no material, or of several in turn."""
    found: dict[int | None, list[Primitive]] = {}
    several = VARIANTS in tree.get("extensionsUsed", [])
    for primitive in primitives:
        found.setdefault(None if several else primitive.entry(tree).get("material"), []).append(primitive)
    yield from found.items()


def _own_coordinates(
    tree: Tree, document: Document, facets: Facets, members: list[Primitive], to: OcclusionTexture, seed: int
) -> TextureGroup | None:
    """Return a group that uses the last set of coordinates that all have, in 0..1 and without overlap; None if there is none."""
    if to.unwrap == "always":
        return None
    for number in reversed(range(min(coordinate_sets(primitive.entry(tree)) for primitive in members))):
        found = [values(document, primitive.entry(tree)["attributes"][f"{SET}{number}"]) for primitive in members]
        layout = TextureLayout.of(members, found, [primitive.faces for primitive in members])
        if layout.fits:
            places, overlap = texels(facets, layout, to.size, seed)
            if overlap <= OVERLAP:
                return TextureGroup(members[0].name, places, [number] * len(members), [None] * len(members))
    return None


def coordinate_sets(entry: Tree) -> int:
    """How many sets of texture coordinates a primitive has; in a compressed part they cannot be used."""
    if DRACO in entry.get("extensions", {}):
        return 0
    number = 0
    while f"{SET}{number}" in entry["attributes"]:
        number += 1
    return number


def _atlas_group(
    writer: GltfWriter, document: Document, facets: Facets, rest: list[Primitive], to: OcclusionTexture, seed: int
) -> TextureGroup:
    for primitive in rest:
        if DRACO in primitive.entry(writer.tree).get("extensions", {}):
            raise SceneError(
                f"mesh '{primitive.name}' is compressed with Draco, and cannot take new vertices; export it without, or bake to vertices"
            )
    made = unwrap(facets, rest, to.size, to.padding, document.notes)
    places, _ = texels(facets, TextureLayout.of(rest, [one.uv for one in made], [one.faces for one in made]), to.size, seed)
    most: dict[int | None, int] = {}  # of a material: its texture has one set of coordinates, whatever wears it
    for primitive in rest:
        entry = primitive.entry(writer.tree)
        for material in materials_of(entry):
            most[material] = max(most.get(material, 0), coordinate_sets(entry))
    every = max(most.values())
    shared = VARIANTS in writer.tree.get("extensionsUsed", [])
    sets = [every if shared else most[p.entry(writer.tree).get("material")] for p in rest]
    return TextureGroup("atlas", places, sets, made)


def materials_of(entry: Tree) -> list[int | None]:
    """Return the material of a primitive, and those that it has in turn (KHR_materials_variants)."""
    mappings = entry.get("extensions", {}).get(VARIANTS, {}).get("mappings", [])
    return [entry.get("material"), *(mapping["material"] for mapping in mappings)]


def write_texture(writer: GltfWriter, document: Document, group: TextureGroup, visibility: F64) -> F32:
    """Write a group's texture (size, size), set it as occlusion texture of its materials, and return it."""
    picture = without_gaps(group.places, visibility)
    texture = writer.picture(_png(picture), f"occlusion of {group.name}")
    clones: dict[tuple[int | None, int], int] = {}
    for primitive, number, made in zip(group.primitives, group.sets, group.unwrapped, strict=True):
        entry = primitive.entry(writer.tree)
        if made is not None:
            _split(writer, document, entry, made, number)
        _wear(writer, document, group, entry, {"index": texture, "texCoord": number}, clones)
    return picture


def without_gaps(places: TexelPlaces, visibility: F64) -> F32:
    """Return visibility as a picture (size, size), row 0 on top; texels that show nothing are as the nearest one that does."""
    from scipy.ndimage import distance_transform_edt

    picture = np.ones((places.size, places.size), np.float32)
    picture.flat[places.places] = visibility
    empty = np.ones(picture.shape, bool)
    empty.flat[places.places] = False
    if empty.all():
        return picture
    rows, columns = distance_transform_edt(empty, return_distances=False, return_indices=True)
    return np.ascontiguousarray(picture[rows, columns])


def _png(picture: F32) -> bytes:
    out = io.BytesIO()
    Image.fromarray(np.round(picture * 255).astype(np.uint8)).save(out, "PNG", optimize=False, compress_level=6)
    return out.getvalue()


def _split(writer: GltfWriter, document: Document, entry: Tree, made: Unwrapped, number: int) -> None:
    """Give a primitive its new vertices: rows of all attributes are copied as they are stored."""

    def copied(attributes: Tree) -> None:
        for name, accessor in attributes.items():
            known = document.entry("accessors", accessor)
            rows = raw(document, accessor, name) if "bufferView" in known or "sparse" in known else None
            if rows is None:
                raise SceneError(f"accessor {accessor} ({name}) has no data")
            new = writer.accessor(rows[made.source], normalized=bool(known.get("normalized", False)), kind=known["type"])
            writer.tree["accessors"][new] |= {key: known[key] for key in ("min", "max", "name") if key in known}
            attributes[name] = new

    copied(entry["attributes"])
    for target in entry.get("targets", []):
        copied(target)
    coordinates = writer.accessor(made.uv)
    for missing in range(coordinate_sets(entry), number + 1):
        entry["attributes"][f"{SET}{missing}"] = coordinates
    dtype = np.uint16 if len(made.source) < 65535 else np.uint32
    entry["indices"] = writer.accessor(made.faces.reshape(-1, 1).astype(dtype), target=INDICES)
    entry.pop("mode", None)


def _wear(
    writer: GltfWriter, document: Document, group: TextureGroup, entry: Tree, texture: Tree, clones: dict[tuple[int | None, int], int]
) -> None:  # fmt: skip
    """Set the occlusion texture of a primitive's materials; of copies of them where others wear them that have none."""

    def worn(material: int | None) -> int:
        key = (material, texture["texCoord"])
        if key not in clones:
            clones[key] = _material(writer, document, group, material, texture)
        return clones[key]

    entry["material"] = worn(entry.get("material"))
    for mapping in entry.get("extensions", {}).get(VARIANTS, {}).get("mappings", []):
        mapping["material"] = worn(mapping["material"])


def _material(writer: GltfWriter, document: Document, group: TextureGroup, number: int | None, texture: Tree) -> int:
    if number is None:
        return writer.add_material({"occlusionTexture": texture})
    material: Tree = writer.tree["materials"][number]
    if "occlusionTexture" in material:
        document.notes.add("occlusion textures that the materials had are replaced")
    baked = {(primitive.mesh, primitive.number) for primitive in group.primitives}
    for mesh, entry in enumerate(document.tree["meshes"]):
        for place, other in enumerate(entry["primitives"]):
            if (mesh, place) not in baked and number in materials_of(other):
                return writer.add_material(material | {"occlusionTexture": texture})
    material["occlusionTexture"] = texture
    return number
