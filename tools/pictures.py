#!/usr/bin/env python3
"""Meshes four real parts and draws the results into docs/images, each picture 150 kB at most.

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
            size = ["--width", "1000", "--height", "700", "--at-most", "150"]
            subprocess.run([sys.executable, str(ROOT / "fixtures/render.py"), str(vtu), str(png), "--view", *map(str, view), *size], check=True)
            print(f"{png}: {png.stat().st_size / 1000:.0f} kB{doubt}")


if __name__ == "__main__":
    main()
