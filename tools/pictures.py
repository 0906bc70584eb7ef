#!/usr/bin/env python3
"""Meshes four real parts and draws the results into docs/images, each picture 150 kB at most; of three of them also the mid-surface as it is before meshing, beside the mesh of quads.

    tools/with-tools.sh python3 tools/pictures.py --parts FOLDER [--midshell BINARY] [--out FOLDER]

FOLDER holds the parts by the names below; docs/images/README.md says where they come from. fixtures/render.py draws, with the Python that
runs this script: it needs pyvista.
"""
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Part, and from where it is seen.
PARTS = {
    "openamr-formed-plastic-cover": (1.0, -1.4, 1.6),
    "openamr-lidar-support-sheet": (1.0, -1.4, 0.9),
    "openamr-wheel-bracket-inner": (1.0, -1.4, 0.9),
    "openamr-camera-upper-body": (1.0, -1.4, 1.2),
}


# Of these also what they are meshed from, and in quads.
BEFORE_AFTER = ["openamr-lidar-support-sheet", "openamr-wheel-bracket-inner", "openamr-camera-upper-body"]


def draw(mesh, png, view, width, height, *more):
    size = ["--width", str(width), "--height", str(height), *more]
    subprocess.run([sys.executable, str(ROOT / "fixtures/render.py"), str(mesh), str(png), "--view", *map(str, view), *size], check=True)


def before_after(part, a):
    """the untangled mid-surface, as the tetrahedra leave it, and the quads made of it, side by side"""
    from PIL import Image

    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        vtu, dump = folder / "mesh.vtu", folder / "dump"
        run = subprocess.run([a.midshell, "mesh", "-q", str(a.parts / f"{part}.step"), "-o", str(vtu), "--element", "quad", "--dump", str(dump)])
        if run.returncode not in (0, 1):
            sys.exit(f"{part}: midshell ended with status {run.returncode}")
        halves = []
        for name, mesh in (("before", dump / "fair-1.vtu"), ("after", vtu)):
            draw(mesh, folder / f"{name}.png", PARTS[part], 900, 700)
            halves.append(Image.open(folder / f"{name}.png").convert("RGB"))
        both = Image.new("RGB", (1800, 700), "white")
        for i, half in enumerate(halves):
            both.paste(half, (900 * i, 0))
        png = a.out / f"{part}-quads.png"
        both.save(png)
        sys.path.insert(0, str(ROOT / "fixtures"))
        from render import shrink

        shrink(png, 150)
        print(f"{png}: {png.stat().st_size / 1000:.0f} kB")


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--parts", type=Path, required=True, help="the folder of the parts")
    p.add_argument("--midshell", default=str(ROOT / "target/release/midshell"), help="the binary")
    p.add_argument("--out", type=Path, default=ROOT / "docs/images", help="the folder of the pictures")
    a = p.parse_args()
    for part, view in PARTS.items():
        with tempfile.TemporaryDirectory() as folder:
            vtu = Path(folder) / "mesh.vtu"
            run = subprocess.run([a.midshell, "mesh", "-q", str(a.parts / f"{part}.step"), "-o", str(vtu)])
            if run.returncode not in (0, 1):
                sys.exit(f"{part}: midshell ended with status {run.returncode}")
            doubt = ", doubted by its own audit: look before you show it" if run.returncode else ""
            png = a.out / f"{part}.png"
            draw(vtu, png, view, 1000, 700, "--at-most", "150")
            print(f"{png}: {png.stat().st_size / 1000:.0f} kB{doubt}")
    for part in BEFORE_AFTER:
        before_after(part, a)


if __name__ == "__main__":
    main()
