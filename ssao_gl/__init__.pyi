from . import gl
from .api import apply, export, normals_from_depth, occlusion, render, sheet, widget
from .bake import Baked, Baking, OcclusionTexture, Vertices, bake
from .batch import batch
from .errors import ContextError, FormatError, GraphError, InputWarning, SceneError, SettingsError, ShaderError, SsaoError
from .io.srgb import multiply
from .loaders.as_scene import as_scene
from .loaders.load import load_scene
from .loaders.pyvista_scenes import from_pyvista
from .loaders.read_options import MoleculeOptions, VolumeOptions
from .methods.alchemy import Alchemy
from .methods.bitmask import Bitmask
from .methods.lecture import Lecture
from .methods.registry import method, register, registry
from .metrics.images import Difference, compare
from .passes.denoise import Joint, LectureBlur, Separable
from .pipeline.light import Light
from .pipeline.settings import Settings, Shading
from .planner import Choice, Target, plan
from .render.effect import Effect
from .render.history import History
from .render.picture import Picture
from .render.pyrender_frames import OffscreenRenderer
from .render.renderer import Renderer
from .sampling.disk import Kernel, Rotation
from .scene.camera import Camera
from .scene.depth_image import DepthImage
from .scene.lamps import Lamp
from .scene.model import Mesh, Scene
from .scene.pose import look_at
from .scene.spheres import Spheres
from .scene.transfer import Transfer, TransferPoint
from .scene.volume import Volume

__version__: str

__all__ = [
    "Alchemy",
    "Baked",
    "Baking",
    "Bitmask",
    "Camera",
    "Choice",
    "ContextError",
    "DepthImage",
    "Difference",
    "Effect",
    "FormatError",
    "GraphError",
    "History",
    "InputWarning",
    "Joint",
    "Kernel",
    "Lamp",
    "Lecture",
    "LectureBlur",
    "Light",
    "Mesh",
    "MoleculeOptions",
    "OcclusionTexture",
    "OffscreenRenderer",
    "Picture",
    "Renderer",
    "Rotation",
    "Scene",
    "SceneError",
    "Separable",
    "Settings",
    "SettingsError",
    "ShaderError",
    "Shading",
    "Spheres",
    "SsaoError",
    "Target",
    "Transfer",
    "TransferPoint",
    "Vertices",
    "Volume",
    "VolumeOptions",
    "apply",
    "as_scene",
    "bake",
    "batch",
    "compare",
    "from_pyvista",
    "export",
    "widget",
    "gl",
    "load_scene",
    "look_at",
    "method",
    "multiply",
    "normals_from_depth",
    "occlusion",
    "plan",
    "register",
    "registry",
    "render",
    "sheet",
]
