"""All demos on one page: runs each, and writes their pictures with what they show to index.html.

Opens without a server:  python demos/gallery.py -o gallery
"""

import argparse
import ast
import subprocess
import sys
from pathlib import Path

from jinja2 import Environment

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>ssao_gl: gallery</title><meta name="viewport" content="width=device-width">
<style>
body { font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 84rem; padding: 0 1rem; color: #222; background: #fff; }
figure { display: inline-block; margin: 0 1rem 1rem 0; max-width: 26rem; vertical-align: top; }
img { width: 100%; } figcaption, .said { color: #555; font-size: .85rem; }
</style></head><body>
<h1>What ssao_gl draws</h1>
<p>Each part is a program of this folder, which ran just now. Soft shadows where things touch are ambient occlusion.</p>
{% for demo in demos %}<h2>{{ demo.name }}</h2>
<p>{{ demo.about }}</p>
{% for picture in demo.pictures %}<figure><img src="{{ picture }}" alt="{{ picture }}" loading="lazy"><figcaption>{{ picture }}</figcaption></figure>
{% else %}<p class="said">{{ demo.said or "made no pictures" }}</p>
{% endfor %}{% endfor %}</body></html>
"""


def run(demo: Path, folder: Path, size: str) -> dict:
    """Run a demo, and return what the page says of it. A demo that fails ends the gallery."""
    command = [sys.executable, str(demo), "-o", str(folder), "--size", size]
    said = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()
    about = ast.get_docstring(ast.parse(demo.read_text("utf-8"))) or ""
    pictures = sorted(path.name for kind in ("png", "webp") for path in folder.glob(f"{demo.stem[:2]}_*.{kind}"))
    print(f"{demo.stem}: {len(pictures)} pictures")
    return {"name": demo.stem, "about": about, "said": said, "pictures": pictures}


def main(folder: Path, size: str, only: str) -> None:
    demos = sorted(Path(__file__).parent.glob(f"{only or '[0-9]'}*.py"))
    made = [run(demo, folder, size) for demo in demos]
    page = Environment(autoescape=True).from_string(PAGE).render(demos=made)
    (folder / "index.html").write_text(page, "utf-8")
    print(folder / "index.html")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", metavar="DIR", type=Path, default=Path("gallery"), help="folder for the page (default: gallery)")
    parser.add_argument("--size", metavar="WxH", default="640x360", help="pixels (default: 640x360)")
    parser.add_argument("--only", metavar="NN", default="", help="demos whose names begin so (default: all)")
    arguments = parser.parse_args()
    arguments.o.mkdir(parents=True, exist_ok=True)
    main(arguments.o, arguments.size, arguments.only)
