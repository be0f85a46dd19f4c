from . import gl
from .api import apply, multiply, normals_from_depth, occlusion, render
from .camera import Camera, look_at
from .difference import Difference, compare
from .effect import Effect
from .errors import ContextError, FormatError, GraphError, SceneError, SettingsError, ShaderError, SsaoError
from .kernel import Kernel, Rotation
from .methods import method, register, registry
from .methods.alchemy import Alchemy
from .methods.bitmask import Bitmask
from .methods.lecture import Lecture
from .passes.blur import Joint, LectureBlur, Separable
from .picture import Picture
from .pipeline import Settings, Shading
from .planner import Choice, Target, plan
from .renderer import Renderer
from .scene import Draw, Scene

__all__ = [
    "Alchemy",
    "Bitmask",
    "Camera",
    "Choice",
    "ContextError",
    "Difference",
    "Draw",
    "Effect",
    "FormatError",
    "GraphError",
    "Joint",
    "Kernel",
    "Lecture",
    "LectureBlur",
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
    "SsaoError",
    "Target",
    "apply",
    "compare",
    "gl",
    "look_at",
    "method",
    "multiply",
    "normals_from_depth",
    "occlusion",
    "plan",
    "register",
    "registry",
    "render",
]
