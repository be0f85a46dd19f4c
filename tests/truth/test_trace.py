"""Ray-traced truth: the surface that cameras see, visibility and its standard error, cache and resumption."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ssao_gl import Camera, Mesh, Scene, look_at
from ssao_gl.errors import FormatError, SceneError, SettingsError
from ssao_gl.sampling.falloff import Falloff, rho
from ssao_gl.scene.lens import Orthographic, Perspective, Pinhole, Projection
from ssao_gl.scene.sample_scene import place, sphere
from ssao_gl.truth import Surface, Tracing, Truth, gather, surface, trace
from ssao_gl.truth import store as caching
from ssao_gl.truth.rays import RayScene

SIZE = (48, 36)
blockers_module = sys.modules["ssao_gl.truth.blockers"]


def quad(center: tuple[float, float, float], right: tuple[float, float, float], up: tuple[float, float, float]) -> Mesh:
    c, r, u = np.array(center), np.array(right), np.array(up)
    return Mesh(np.array([c - r - u, c + r - u, c + r + u, c - r + u], np.float32), np.array([[0, 1, 2], [0, 2, 3]], np.uint32))


POSE = look_at((2, 1.5, 4), (0.2, 0.1, 0))
OBLIQUE = np.array([[1.2, 0, 0.3, 0], [0, 1.6, -0.2, 0], [0, 0, -1.01, -0.2], [0, 0, -1, 0]])
LENSES = {
    "perspective": Perspective(0.8, 0.1, 50.0),
    "infinite": Perspective(0.8, 0.1),
    "orthographic": Orthographic(3.0, 0.1, 50.0),
    "orthographic from within": Orthographic(3.0, -50.0, 50.0),
    "pinhole off centre": Pinhole(50, 40, 20, 25, 48, 36),
    "off centre": Projection(OBLIQUE),
}


@pytest.mark.parametrize("name", LENSES)
def test_points_lie_behind_pixel_centres(name: str) -> None:
    scene = Scene([quad((0, 0, 0), (9, 0, 0), (0, 0, 9)), quad((0, 3, -4), (9, 0, 1), (0, 5, 0))])
    camera = Camera(LENSES[name], POSE)
    found = surface(scene, camera, SIZE)
    clip = np.c_[found.points(), np.ones(len(found.origins))] @ (camera.view(SIZE).projection @ np.linalg.inv(POSE)).T
    ndc = clip[:, :2] / clip[:, 3:]
    rows, columns = np.nonzero(found.covered)
    assert len(rows) > 800
    assert np.abs((ndc[:, 0] + 1) / 2 * SIZE[0] - 0.5 - columns).max() < 2e-3
    assert np.abs((1 - ndc[:, 1]) / 2 * SIZE[1] - 0.5 - rows).max() < 2e-3
    world = np.c_[camera.view(SIZE).points(found.depth)[found.covered], np.ones(len(rows))] @ POSE.T
    assert np.abs(world[:, :3] - found.points()).max() < 1e-4  # depth says the same


def test_row_0_is_the_top_and_background_is_exactly_1() -> None:
    scene = Scene([quad((0, 1, -3), (9, 0, 0), (0, 0.9, 0)), quad((0, 1, -2.9), (9, 0, 0), (0, 0.1, 0))])
    found = trace(scene, Camera.perspective(1.0, 0.1, 9.0), (16, 16), Tracing(radius=1.0, spp=16))
    assert found.depth[:6].min() > 0 and found.depth[10:].max() == 0
    assert (found.visibility[10:] == 1).all() and (found.stderr[10:] == 0).all()
    assert found.visibility[found.covered].min() < 1


def test_normals_face_the_viewer_whatever_the_winding() -> None:
    ball = sphere(64)
    turned = (ball[0], ball[1][:, ::-1].copy(), -ball[2])
    for mesh in (ball, turned):
        squashed = Mesh(*mesh, transforms=place((1.0, 0.5, 1.0), (0, 0, 0))[None])
        found = surface(Scene([squashed]), Camera.perspective(0.9, 0.1, 9.0, look_at((0, 1, 3), (0, 0, 0))), SIZE)
        p = found.points()
        exact = p * [1, 4, 1]
        exact /= np.linalg.norm(exact, axis=1, keepdims=True)
        assert (found.shading * exact).sum(1).min() > 0.999
        assert (found.normals * exact).sum(1).min() > 0.99
        assert np.abs(np.linalg.norm(found.normals, axis=1) - 1).max() < 1e-6


def test_a_lone_plane_is_open_however_it_is_turned_and_cut() -> None:
    for seed in range(4):
        random = np.random.default_rng(seed)
        steps = np.sort(random.random(21)) * 2 - 1
        x, y = np.meshgrid(steps, steps)
        turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
        at = random.normal(size=3)
        index = (np.arange(20)[:, None] * 21 + np.arange(20)).ravel()
        triangles = np.concatenate(
            [np.stack([index, index + 1, index + 21], 1), np.stack([index + 1, index + 22, index + 21], 1)]
        )
        scene = Scene.from_arrays(np.stack([x, y, 0 * x], -1).reshape(-1, 3) @ turn.T + at, triangles)
        camera = Camera.perspective(0.8, 0.01, None, look_at(at + 1.5 * turn[:, 2] + 0.5 * turn[:, 0], at, turn[:, 1]))
        assert (trace(scene, camera, SIZE, Tracing(radius=1e6, spp=64)).visibility == 1).all()


@pytest.mark.parametrize("scale", [1e-6, 0.3, 1e6])
def test_unit_and_place_do_not_matter(courtyard: Scene, seen: Surface, scale: float) -> None:
    shift = np.array([7e6, -1e7, 3e6]) * scale
    move = np.eye(4)
    move[:3, :3] *= scale
    move[:3, 3] = shift
    moved = Scene([dataclasses.replace(draw, transforms=move @ draw.transforms) for draw in courtyard.meshes])
    camera = courtyard.cameras[0]
    pose = camera.pose.copy()
    pose[:3, 3] = pose[:3, 3] * scale + shift
    far = Camera(Perspective(camera.lens.yfov, 1.0 * scale, 30.0 * scale), pose)  # type: ignore[attr-defined]
    here = gather(seen, Tracing(radius=0.7, spp=64))
    there = trace(moved, far, SIZE, Tracing(radius=0.7 * scale, spp=64))
    assert np.abs(there.depth / scale - here.depth).max() < 1e-3  # where a ball is grazed
    assert np.abs(there.visibility - here.visibility).max() <= 4 / 64
    assert np.abs(there.visibility - here.visibility).mean() < 1e-3


@pytest.mark.parametrize("falloff", Falloff)
def test_falloffs_under_a_ceiling(falloff: Falloff) -> None:
    scene = Scene([quad((0, 0, 0), (200, 0, 0), (0, 0, 200)), quad((0, 1, 0), (200, 0, 0), (0, 0, 200))])
    camera = Camera.perspective(0.5, 0.01, 50.0, look_at((0, 0.9, 0.1), (0, 0, 0)))
    radius = 2.5
    found = trace(scene, camera, (8, 6), Tracing(radius=radius, falloff=falloff, spp=4096))
    # The ceiling at height 1 is 1 / cos away; sin^2 is uniform in 0..1 under cosine weight.
    cosine = np.sqrt((np.arange(1_000_000) + 0.5) / 1_000_000)
    assert found.visibility == pytest.approx(1 - rho(falloff, 1 / cosine / radius).mean(), abs=0.004)


def test_falloff_shapes() -> None:
    x = np.array([0, 0.25, 0.4456, 0.9, 1, 2, np.inf])
    assert rho("hard", x).tolist() == [1, 1, 1, 1, 0, 0, 0]
    assert rho("quadratic", x)[:2] == pytest.approx([1, 0.5625])
    assert rho("obscurance", x)[:2] == pytest.approx([1, 0.5])
    alchemy = rho("alchemy", x)
    assert alchemy[0] == 0 and alchemy[2] == pytest.approx(1, abs=1e-3) and 0 < alchemy[3] < 1
    assert all((rho(f, x)[4:] == 0).all() for f in Falloff)
    assert rho("quadratic", x.astype(np.float32)).dtype == np.float32


@pytest.mark.parametrize("spp", [1, 2, 3, 8, 63, 64, 100, 1000, 4096])
def test_batches_hold_what_was_asked_for(spp: int) -> None:
    length, count = Tracing(spp=spp).batches
    assert length & (length - 1) == 0
    assert spp <= length * count < spp + length
    assert count >= min(spp, 2)


class Cut:
    """Progress that interrupts after some calls, and remembers what it was told."""

    def __init__(self, after: int | None = None) -> None:
        self.after, self.told = after, []  # type: ignore[var-annotated]

    def __call__(self, done: int, total: int) -> None:
        self.told.append((done, total))
        if self.after is not None and len(self.told) == self.after:
            raise KeyboardInterrupt


def same(a: Truth, b: Truth) -> bool:
    return all(getattr(a, n).tobytes() == getattr(b, n).tobytes() for n in ("visibility", "stderr", "depth")) and a.spp == b.spp


@pytest.mark.parametrize("tracing", [Tracing(spp=40), Tracing(max_stderr=0.03)])
def test_interrupted_runs_go_on_and_give_the_same_bytes(courtyard: Scene, tmp_path: Path, tracing: Tracing) -> None:
    camera, size = courtyard.cameras[0], (160, 120)  # several blocks
    whole = trace(courtyard, camera, size, tracing)
    for after in (1, 2, 3):
        with pytest.raises(KeyboardInterrupt):
            trace(courtyard, camera, size, tracing, cache=tmp_path, progress=Cut(after))
        assert [p.suffixes for p in tmp_path.iterdir()] == [[".part", ".npz"]]
    rest = Cut()
    resumed = trace(courtyard, camera, size, tracing, cache=tmp_path, progress=rest)
    assert same(resumed, whole) and not resumed.cached
    pixels = int(whole.covered.sum())
    assert rest.told[0][0] > pixels * 8 and rest.told[-1] == (whole.rays, whole.rays)
    assert [p.suffixes for p in tmp_path.iterdir()] == [[".npz"]]


def test_results_are_cached_by_content(courtyard: Scene, tmp_path: Path) -> None:
    camera, tracing = courtyard.cameras[0], Tracing(spp=8)
    first = trace(courtyard, camera, SIZE, tracing, cache=tmp_path)
    painted = Scene([dataclasses.replace(d, color=(1, 0, 0), name="x") for d in courtyard.meshes], name="other")
    again = trace(painted, dataclasses.replace(camera, name="other"), SIZE, tracing, cache=tmp_path)
    assert again.cached and not first.cached and same(first, again)
    moved = courtyard.meshes[0].transforms.copy()
    moved[0, 0, 3] += 1e-9
    pose = camera.pose.copy()
    pose[0, 3] += 1e-9
    others = [
        (Scene([dataclasses.replace(courtyard.meshes[0], transforms=moved), *courtyard.meshes[1:]]), camera, SIZE, tracing),
        (Scene(courtyard.meshes[1:]), camera, SIZE, tracing),
        (courtyard, dataclasses.replace(camera, pose=pose), SIZE, tracing),
        (courtyard, camera, (48, 37), tracing),
        *((courtyard, camera, SIZE, dataclasses.replace(tracing, **change)) for change in (
            {"radius": 0.5}, {"falloff": "quadratic"}, {"normals": "shading"}, {"spp": 16}, {"seed": 1}, {"max_stderr": 0.5})),
    ]  # fmt: skip
    keys = {caching.content_key(*other) for other in others} | {caching.content_key(courtyard, camera, SIZE, tracing)}
    assert len(keys) == len(others) + 1


@pytest.mark.parametrize("damage", ["flipped", "cut", "empty", "other"])
@pytest.mark.parametrize("which", ["result", "partial"])
def test_damaged_files_are_noticed(
    courtyard: Scene, tmp_path: Path, damage: str, which: str, caplog: pytest.LogCaptureFixture
) -> None:
    camera, tracing = courtyard.cameras[0], Tracing(spp=8)
    whole = trace(courtyard, camera, SIZE, tracing)
    if which == "partial":
        with pytest.raises(KeyboardInterrupt):
            trace(courtyard, camera, SIZE, tracing, cache=tmp_path, progress=Cut(1))
    else:
        trace(courtyard, camera, SIZE, tracing, cache=tmp_path)
    (path,) = tmp_path.iterdir()
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 16
    path.write_bytes(
        {"flipped": bytes(content), "cut": content[: len(content) // 2], "empty": b"", "other": b"x" * 999}[damage]
    )
    again = trace(courtyard, camera, SIZE, tracing, cache=tmp_path)
    assert same(again, whole) and not again.cached
    assert len([r for r in caplog.records if "damaged" in r.message]) == 1
    assert trace(courtyard, camera, SIZE, tracing, cache=tmp_path).cached


def test_a_full_disk_costs_the_cache_and_not_the_result(
    courtyard: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(caching.np, "savez", full)
    found = trace(courtyard, courtyard.cameras[0], SIZE, Tracing(spp=8), cache=tmp_path)
    assert found.visibility.min() < 0.9
    assert "No space left" in caplog.text and list(tmp_path.iterdir()) == []


def test_errors_are_one_line(courtyard: Scene, seen: Surface, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for bad in ({"radius": 0}, {"radius": np.inf}, {"spp": 0}, {"max_stderr": 0}, {"falloff": "hrad"}, {"normals": "x"}):
        with pytest.raises(SettingsError, match=r"^truth\.\w+=.*must be"):
            Tracing(**bad)  # type: ignore[arg-type]
    with pytest.raises(SettingsError, match="too small"):
        gather(seen, Tracing(radius=1e-7))
    (tmp_path / "file").write_text("")
    with pytest.raises(FormatError, match="cannot make the folder"):
        trace(courtyard, courtyard.cameras[0], SIZE, Tracing(spp=1), cache=tmp_path / "file")
    monkeypatch.setattr(blockers_module, "machine_memory", lambda: 1e6)
    with pytest.raises(SceneError, match=r"17,832 triangles .* GiB"):
        RayScene(courtyard)
    for name, what in (
        ("embreex", lambda: RayScene(courtyard)),
        ("scipy.stats", lambda: gather(seen, Tracing(radius=1, seed=9))),
    ):
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(SettingsError, match=r"pip install 'ssao_gl\[truth\]'"):
            what()


def test_a_camera_that_sees_nothing(courtyard: Scene) -> None:
    away = Camera.perspective(0.8, 0.1, 9.0, look_at((9, 9, 9), (18, 18, 18)))
    found = trace(courtyard, away, SIZE, Tracing(spp=8))
    assert (found.visibility == 1).all() and not found.covered.any() and found.noise == 0 and found.rays == 0


def test_nothing_is_imported_before_it_is_needed() -> None:
    code = "import sys, ssao_gl, ssao_gl.truth, ssao_gl.metrics; print({'embreex', 'scipy', 'skimage', 'flip_evaluator'} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "set()\n"


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from ssao_gl.cli import main

    def run(*arguments: object) -> tuple[int, str]:
        with pytest.raises(SystemExit) as end:
            main(["truth", "--size", "32x18", "--spp", "8", "--cache", str(tmp_path / "cache"), *map(str, arguments)])
        printed = capsys.readouterr()
        assert "Traceback" not in printed.err
        return int(str(end.value.code)), printed.out + printed.err

    code, text = run("-o", tmp_path / "v.npy")
    assert code == 0 and "8 rays a pixel" in text and "cache" not in text.split("standard error")[1]
    assert np.load(tmp_path / "v.npy").shape == (18, 32)
    code, text = run("-o", tmp_path / "all", "--json", tmp_path / "v.json")
    assert code == 0 and text.rstrip().endswith("from the cache")
    assert {p.name for p in (tmp_path / "all").iterdir()} >= {"visibility.npy", "stderr.npy", "depth.png"}
    assert np.array_equal(np.load(tmp_path / "all/visibility.npy"), np.load(tmp_path / "v.npy"))
    for bad in (
        ("--radius", 0),
        ("--radius", "inf"),
        ("-o", tmp_path / "v.jpg"),
        ("-o", tmp_path / "none/v.png"),
        ("--falloff", "x"),
    ):
        code, text = run(*bad)
        assert code == 2 and text.count("\n") == 1, text
