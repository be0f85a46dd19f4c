"""Which extensions of glTF are read, which change nothing that is drawn, and what is said of the others."""

from __future__ import annotations

from typing import Any

from ..errors import SceneError, near_miss, one_line
from .gltf_document import Document
from .gltf_draco import DRACO, need_draco
from .gltf_meshopt import MESHOPT, need_meshopt

READ = frozenset({
    DRACO, *MESHOPT, "KHR_mesh_quantization", "KHR_texture_transform", "EXT_mesh_gpu_instancing", "KHR_node_visibility",
    "KHR_materials_variants", "KHR_materials_unlit", "KHR_materials_pbrSpecularGlossiness", "EXT_texture_webp",
    "KHR_lights_punctual",
})  # fmt: skip
HARMLESS = frozenset({
    "EXT_lights_image_based", "EXT_lights_ies", "KHR_xmp", "KHR_xmp_json_ld", "KHR_animation_pointer",
    "KHR_audio_emitter", "KHR_interactivity", "KHR_node_hoverability", "KHR_node_selectability", "KHR_physics_rigid_bodies",
    "KHR_implicit_shapes", "KHR_collision_shapes", "KHR_blend", "MSFT_lod", "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic", "EXT_mesh_features", "EXT_feature_metadata", "EXT_structural_metadata",
    "EXT_instance_features", "EXT_mesh_manifold", "CESIUM_RTC", "FB_geometry_metadata", "GRIFFEL_bim_data", "VRM", "VRMC_vrm",
    "VRMC_springBone", "VRMC_materials_mtoon", "VRMC_node_constraint", "KHR_materials_emissive_strength", "KHR_materials_ior",
})  # fmt: skip
"""They change neither shape nor base colour."""
PREFIXES = ("KHR_materials_", "EXT_materials_", "ADOBE_materials_", "MOZ_", "OMI_", "VRMC_", "BLENDER_", "AGI_")
"""Of extensions of light on surfaces, sound, behaviour and single programs."""
PICTURES = frozenset(
    {"KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_avif", "KHR_technique_webgl", "KHR_techniques_webgl"}
)
"""Packings of pictures and shaders: without them the shape can still be drawn."""


def check_extensions(document: Document) -> None:
    """Raise SceneError for what a file needs and is not read; note, once, what it uses besides."""
    tree: dict[str, Any] = document.tree
    required = [str(name) for name in tree.get("extensionsRequired", [])]
    for name in required:
        if name in MESHOPT:
            need_meshopt()
        elif name == DRACO:
            need_draco()
        elif not _known(name) and name not in PICTURES:
            shown = one_line(name, 60)
            raise SceneError(
                f"needs the glTF extension {shown}, which cannot be read; export it without.{near_miss(shown, READ)}"
            )
    used = dict.fromkeys(str(name) for name in [*tree.get("extensionsUsed", []), *required])
    missed = [one_line(name, 60) for name in used if not _known(name)]
    if missed:
        document.notes.add(f"uses glTF extensions that are not read: {', '.join(missed[:10])}")


def _known(name: str) -> bool:
    return name in READ or name in HARMLESS or name.startswith(PREFIXES)
