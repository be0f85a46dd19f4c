"""Materials of glTF: base colour, its texture with sampler and coordinates, alpha (glTF 2.0, 3.8 and 3.9).

Read are KHR_texture_transform, EXT_texture_webp, KHR_materials_pbrSpecularGlossiness and KHR_materials_unlit, whose colour
is the base colour. Of KHR_materials_variants the default materials are drawn.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, one_line
from ..scene.baked_visibility import BakedTexture
from ..scene.material import AlphaMode, ColorTexture, Material, Wrap
from .gltf_document import Document, Tree, data_uri, index
from .picture_files import Texels
from .resolver import FolderResolver

GLOSS, WEBP, TRANSFORM = "KHR_materials_pbrSpecularGlossiness", "EXT_texture_webp", "KHR_texture_transform"
WRAPS: dict[int, Wrap] = {33071: "clamp", 33648: "mirror", 10497: "repeat"}
NEAREST = 9728
MIPMAPS = frozenset({9984, 9985, 9986, 9987})
ALPHA: dict[str, AlphaMode] = {"OPAQUE": "OPAQUE", "MASK": "MASK", "BLEND": "BLEND"}


@dataclass(frozen=True)
class TexturedMaterial:
    """A material, and where its texture's coordinates are: the number of the set, and (2, 3) from them to the picture."""

    material: Material
    coordinates: int = 0
    transform: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class OcclusionMap:
    """The occlusion texture of a material (glTF 2.0, 3.9.3), not unpacked: its strength, coordinates and transform."""

    texture: BakedTexture
    strength: float
    coordinates: int
    transform: NDArray[np.float64] | None


@dataclass
class Materials:
    """The materials of a document that are asked for; each picture is unpacked once."""

    document: Document
    texels: Texels = field(default_factory=Texels)
    _surfaces: dict[int, TexturedMaterial] = field(default_factory=dict)
    _white: dict[int, Material] = field(default_factory=dict)
    _pictures: dict[int, NDArray[np.uint8] | None] = field(default_factory=dict)
    _occlusion: dict[int, OcclusionMap | None] = field(default_factory=dict)

    def surface(self, number: Any) -> TexturedMaterial:
        """A material by its number; what of it is broken is left out."""
        if index(number) not in self._surfaces:
            self._surfaces[number] = self._surface(self.document.entry("materials", number), number)
        return self._surfaces[number]

    def without_factor(self, number: Any) -> Material:
        """A material for vertex colours that have its factor in them."""
        if number not in self._white:
            self._white[number] = replace(self.surface(number).material, base_color=(1.0, 1.0, 1.0, 1.0))
        return self._white[number]

    def _surface(self, entry: Tree, number: int) -> TexturedMaterial:
        gloss = entry.get("extensions", {}).get(GLOSS)
        facts, name = (entry.get("pbrMetallicRoughness", {}), "baseColor") if gloss is None else (gloss, "diffuse")
        r, g, b, a = _numbers(facts.get(f"{name}Factor"), (1.0, 1.0, 1.0, 1.0))
        er, eg, eb = _numbers(entry.get("emissiveFactor"), (0.0, 0.0, 0.0))
        material = Material(
            (r, g, b, a), None, ALPHA.get(entry.get("alphaMode", "OPAQUE"), "OPAQUE"),
            _numbers([entry.get("alphaCutoff")], (0.5,), math.inf)[0], (er, eg, eb),
            *_shine(facts), bool(entry.get("doubleSided", False)), one_line(entry.get("name", ""), 50),
        )  # fmt: skip
        texture = facts.get(f"{name}Texture")
        if not isinstance(texture, dict):
            return TexturedMaterial(material)
        found = self._texture(texture, f"material '{material.name or number}'")
        if found is None:
            return TexturedMaterial(material)
        return TexturedMaterial(replace(material, base_color_texture=found), *_coordinates(texture))

    def occlusion(self, number: Any) -> OcclusionMap | None:
        """The occlusion texture of a material; None without one that could be read."""
        if index(number) not in self._occlusion:
            entry = self.document.entry("materials", number)
            texture = entry.get("occlusionTexture")
            where = f"occlusion texture of material '{one_line(entry.get('name', ''), 50) or number}'"
            try:
                self._occlusion[number] = None if not isinstance(texture, dict) else OcclusionMap(
                    self._unread(texture, where), _numbers([texture.get("strength")], (1.0,))[0], *_coordinates(texture)
                )  # fmt: skip
            except (LookupError, TypeError, AttributeError, ValueError, SceneError):
                self._occlusion[number] = None  # nobody may want it
        return self._occlusion[number]

    def _unread(self, texture: Tree, where: str) -> BakedTexture:
        """A texture whose picture is unpacked when it is wanted; of a GLB file a copy of its bytes is kept."""
        entry = self.document.entry("textures", texture["index"])
        image = self.document.entry("images", entry.get("extensions", {}).get(WEBP, entry)["source"])
        content, beside = (self._content(image), None) if "bufferView" in image else (b"", self.document.beside)
        return BakedTexture(partial(_picture, content, image.get("uri"), beside, where), *self._sampling(entry), where)

    def _sampling(self, entry: Tree) -> tuple[tuple[Wrap, Wrap], bool, bool]:
        """Wrapping, whether texels are not blended, and whether there are smaller copies."""
        sampler = self.document.entry("samplers", entry["sampler"]) if "sampler" in entry else {}
        least, most = sampler.get("minFilter"), sampler.get("magFilter")
        wrap = WRAPS.get(sampler.get("wrapS", 0), "repeat"), WRAPS.get(sampler.get("wrapT", 0), "repeat")
        return wrap, most == NEAREST, least is None or least in MIPMAPS

    def _texture(self, texture: Tree, where: str) -> ColorTexture | None:
        try:
            entry = self.document.entry("textures", texture["index"])
            source = entry.get("extensions", {}).get(WEBP, entry)["source"]
            array = self._picture(source, where)
            sampling = self._sampling(entry)
        except (LookupError, TypeError, AttributeError, ValueError):
            self.document.notes.add(f"{where}: drawn without its texture, which is in no format that is read")
            return None
        if array is None:
            return None
        return ColorTexture(array, *sampling, where)

    def _picture(self, number: Any, where: str) -> NDArray[np.uint8] | None:
        """None, and a note, for one that cannot be used."""
        if index(number) not in self._pictures:
            self._pictures[number] = None
            try:
                self._pictures[number] = self.texels.unpack(self._content(self.document.entry("images", number)))
            except (LookupError, TypeError, AttributeError):
                raise
            except Exception as error:
                if "not in its folder" not in str(error):  # that is said by name
                    self.document.notes.add(f"{where}: drawn without its texture ({one_line(error, 150)})")
        return self._pictures[number]

    def _content(self, image: Mapping[str, Any]) -> bytes:
        if "bufferView" in image:
            return self.document.view(image["bufferView"]).tobytes()
        return _named(image["uri"], self.document.beside)


def _named(uri: str, beside: FolderResolver) -> bytes:
    return data_uri(uri) if uri.startswith("data:") else beside.get(uri)


def _picture(content: bytes, uri: str | None, beside: FolderResolver | None, where: str) -> NDArray[np.uint8]:
    """Unpack a picture from its bytes, or from what ``uri`` names. Raises SceneError."""
    try:
        return Texels().unpack(content if uri is None or beside is None else _named(uri, beside))
    except Exception as error:  # Pillow's are of many kinds
        raise SceneError(f"{where}: cannot be read ({one_line(error, 150)})") from None


def _coordinates(texture: Tree) -> tuple[int, NDArray[np.float64] | None]:
    """The set of texture coordinates of a texture, and (2, 3) from them to the picture."""
    more = texture.get("extensions", {}).get(TRANSFORM, {})
    return index(more.get("texCoord", texture.get("texCoord", 0))), _transform(more)


def placed(uv: NDArray[Any], transform: NDArray[np.float64] | None) -> NDArray[Any]:
    """Return coordinates (n, 2) as those in the picture."""
    return uv if transform is None else uv @ transform[:, :2].T + transform[:, 2]


def _numbers(given: Any, default: tuple[float, ...], most: float = 1.0) -> tuple[float, ...]:
    """As many numbers as in ``default``, cut to 0..most; the default for what is none."""
    usable = isinstance(given, list) and len(given) == len(default)
    if not usable or not all(isinstance(value, int | float) and math.isfinite(value) for value in given):
        return default
    return tuple(float(min(max(value, 0), most)) for value in given)


def _transform(entry: Tree) -> NDArray[np.float64] | None:
    """KHR_texture_transform: translation x rotation x scale (its README), as (2, 3); None where it does nothing."""
    if not {"offset", "rotation", "scale"} & set(entry):
        return None
    c, s = math.cos(float(entry.get("rotation", 0))), math.sin(float(entry.get("rotation", 0)))
    (x, y), (u, v) = entry.get("scale", (1, 1)), entry.get("offset", (0, 0))
    return np.array([[c * x, s * y, u], [-s * x, c * y, v]], np.float64)


def _shine(facts: Tree) -> tuple[float, float]:
    """Metalness and roughness of a surface. Their texture is not read: what has one is more often no metal than one."""
    if "glossinessFactor" in facts or "diffuseFactor" in facts:
        return 0.0, 1.0 - _numbers([facts.get("glossinessFactor")], (1.0,))[0]
    usual = 0.0 if "metallicRoughnessTexture" in facts else 1.0
    metallic = usual * _numbers([facts.get("metallicFactor")], (1.0,))[0]
    return metallic, _numbers([facts.get("roughnessFactor")], (1.0,))[0]
