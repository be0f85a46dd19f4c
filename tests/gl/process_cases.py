"""What tests of processes run in a process of its own: ``python -m tests.gl.process_cases CASE PROVIDER``. Prints JSON lines.

Each starts others after a render, which is what used to wait for ever.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import pickle
import queue
import sys
import threading
from collections.abc import Callable
from typing import Any

import numpy as np

import ssao_gl as ao
from ssao_gl.scene.sample_scene import default_scene

FORK = multiprocessing.get_context("fork")
SCENE = default_scene()
SECONDS = 10
"""In which every child must have ended."""


def draw(renderer: ao.Renderer) -> Any:
    return renderer.render(SCENE, None, (48, 36)).visibility


def answer(work: Callable[[], Any], right: Any) -> list[str]:
    """["right" or "wrong"], or the error's name and message."""
    try:
        return ["right" if np.array_equal(work(), right) else "wrong"]
    except ao.SsaoError as error:
        return [type(error).__name__, str(error)]


def in_a_child(work: Callable[[], Any], right: Any) -> list[str]:
    answers = FORK.SimpleQueue()
    child = FORK.Process(target=lambda: answers.put(answer(work, right)))
    child.start()
    child.join(SECONDS)
    if child.is_alive():
        child.kill()
        return ["hang"]
    return ["no answer"] if answers.empty() else answers.get()


def kinds(provider: str) -> None:
    """A new Renderer before any other; then a new one, an inherited one and a closed one; and the parent draws on."""
    print(json.dumps(["early", *in_a_child(lambda: draw_one(provider).std() > 0, True)]), flush=True)
    kept, closed = ao.Renderer(provider), ao.Renderer(provider)
    right = draw(kept)
    draw(closed)
    closed.release()

    def new() -> Any:
        with ao.Renderer(provider) as renderer:
            return draw(renderer)

    def leave() -> Any:
        kept.release()  # as a with block would
        return right

    for kind, work in (("new", new), ("inherited", lambda: draw(kept)), ("closed", lambda: draw(closed)), ("released", leave)):
        print(json.dumps([kind, *in_a_child(work, right)]), flush=True)
    print(json.dumps(["parent", *answer(lambda: draw(kept), right)]))


def draw_one(provider: str) -> Any:
    with ao.Renderer(provider) as renderer:
        return draw(renderer)


def pool(provider: str, start: Any = FORK) -> None:
    """A pool of two, as most programs use them: the error comes back to the parent."""
    right = draw_one(provider)
    with start.Pool(2) as workers:
        tasks = [workers.apply_async(draw_one, (provider,)) for _ in range(4)]
        for task in tasks:
            try:
                print(json.dumps(["pool", *answer(lambda task=task: task.get(SECONDS), right)]), flush=True)
            except multiprocessing.TimeoutError:
                print(json.dumps(["pool", "hang"]), flush=True)


def spawn(provider: str) -> None:
    """The cure that the error names; and a renderer itself, which no process can be sent."""
    pool(provider, multiprocessing.get_context("spawn"))
    with ao.Renderer(provider) as renderer:
        print(json.dumps(["sent", *answer(lambda: pickle.dumps(renderer), None)]))


def busy(provider: str) -> None:
    """A fork while another thread draws: the child finds the renderer locked, by a thread that it does not have."""
    renderer = ao.Renderer(provider)
    right = draw(renderer)
    held, done = threading.Event(), threading.Event()

    def hold() -> None:
        with renderer.ctx.current():
            held.set()
            done.wait()

    thread = threading.Thread(target=hold)
    thread.start()
    held.wait()

    def leave() -> Any:
        renderer.ctx.release()  # as the collector would
        return right

    for kind, work in (("inherited", lambda: draw(renderer)), ("new", lambda: draw_one(provider)), ("released", leave)):
        print(json.dumps([kind, *in_a_child(work, right)]), flush=True)
    done.set()
    thread.join()


def prefetch(provider: str) -> None:
    """As PyTorch's DataLoader: workers with a queue of indices each, two batches ahead, one queue of answers, a thread that empties it."""
    data = ao.Renderer(provider)  # a data set that keeps one
    right = draw(data)
    answers: Any = FORK.Queue()

    def loop(indices: Any) -> None:
        while (index := indices.get()) is not None:
            answers.put((index, answer(lambda: draw(data), right)))

    asked = [FORK.SimpleQueue() for _ in range(2)]
    workers = [FORK.Process(target=loop, args=(indices,), daemon=True) for indices in asked]
    for worker in workers:
        worker.start()
    here: queue.Queue[Any] = queue.Queue()
    threading.Thread(target=lambda: [here.put(answers.get()) for _ in range(8)], daemon=True).start()
    for index in range(8):
        asked[index % 2].put(index)
    for indices in asked:
        indices.put(None)
    for _ in range(8):
        try:
            print(json.dumps(["prefetch", *here.get(timeout=SECONDS)[1]]), flush=True)
        except queue.Empty:
            print(json.dumps(["prefetch", "hang"]), flush=True)
    for worker in workers:
        worker.join(SECONDS)
        if worker.is_alive():
            print(json.dumps(["prefetch", "hang"]), flush=True)


def plain(provider: str) -> None:
    """os.fork, and a child that ends as programs do, exit handlers and all."""
    with ao.Renderer(provider) as renderer:
        draw(renderer)
    child = os.fork()
    if not child:
        sys.exit(7)
    timer = threading.Timer(SECONDS, os.kill, (child, 9))
    timer.start()
    print(json.dumps(["plain", str(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))]))
    timer.cancel()


def dropped(provider: str) -> None:
    """Growth in MiB by renderers that nobody released."""

    def resident() -> float:
        with open("/proc/self/statm") as file:  # noqa: PTH123
            return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE") / 2**20

    draw(first := ao.Renderer(provider))
    before = resident()
    held = [ao.Renderer(provider) for _ in range(120)]
    for renderer in held:
        draw(renderer)
    full = resident()
    del held, renderer
    print(json.dumps(["dropped", full - before, resident() - before]))
    draw(first)


if __name__ == "__main__":
    cases = (kinds, pool, spawn, busy, prefetch, plain, dropped)
    {case.__name__: case for case in cases}[sys.argv[1]](sys.argv[2])
