#!/usr/bin/env python3
"""Meshes of quads beside Gmsh's, on the same mid-surfaces at the same size, as a table in a Markdown page, between its markers.

    tools/with-tools.sh .venv/bin/python3 tools/quads_beside_gmsh.py [--page docs/benchmarks.md] [NAME ...]

midshell gets the solid of each fixture (`--element quad`); Gmsh gets its mid-surface as CAD faces, drawn by hand in tests/python/measure_ideal.py, and meshes it with
every algorithm that makes quads (6 frontal, 8 frontal for quads, 9 packing of parallelograms) and both recombinations (1 blossom, 3 blossom full-quad). Scaled Jacobians
are Verdict's, of all quads; triangles are counted beside them.
"""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import gmsh
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/python"))
import measure_ideal  # noqa: E402

# Flat ones and curved ones, with holes, junctions and creases; sizes as coarse as an analyst would take.
PARTS = {"plate_web": 5, "plate_holes": 4, "t_sharp": 4, "open_box": 5, "egg_crate": 5, "ribs_crossing": 4, "slots": 4, "tube": 4, "tubes_t": 4}
WAYS = [(algorithm, recombination) for algorithm in (6, 8, 9) for recombination in (1, 3)]


def jacobians(p):
    """#Q least scaled Jacobians of quads with corners p, #Q by 4 by 3, as Verdict has them"""
    edge = np.roll(p, -1, axis=1) - p
    length = np.linalg.norm(edge, axis=2)
    corner = np.cross(np.roll(edge, 1, axis=1), edge)
    centre = np.cross(edge[:, 0] - edge[:, 2], edge[:, 1] - edge[:, 3])
    centre /= np.linalg.norm(centre, axis=1)[:, None]
    return (np.einsum("qkc,qc->qk", corner, centre) / (np.roll(length, 1, axis=1) * length)).min(axis=1)


def by_gmsh(name, size, algorithm, recombination):
    """quads, triangles, least and mean scaled Jacobian, seconds of meshing; None where it gives up"""
    gmsh.initialize(["gmsh", "-nopopup"], interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        draft = measure_ideal.Draft()
        _, drop = measure_ideal.draw(name, draft)
        draft.cut(drop)
        wanted = {"MeshSizeMin": size, "MeshSizeMax": size, "Algorithm": algorithm, "RecombineAll": 1, "RecombinationAlgorithm": recombination, "RandomSeed": 1}
        for key, value in wanted.items():
            gmsh.option.setNumber("Mesh." + key, value)
        began = time.monotonic()
        gmsh.model.mesh.generate(2)
        seconds = time.monotonic() - began
        tags, xyz, _ = gmsh.model.mesh.getNodes()
        row = np.zeros(int(tags.max()) + 1, int)
        row[tags.astype(int)] = np.arange(len(tags))
        kinds, _, nodes = gmsh.model.mesh.getElements(2)
        of = {int(kind): row[n.astype(int)] for kind, n in zip(kinds, nodes)}
        quads = of.get(3, np.zeros(0, int)).reshape(-1, 4)
        worth = np.abs(jacobians(xyz.reshape(-1, 3)[quads])) if len(quads) else np.zeros(1)
        return len(quads), len(of.get(2, ())) // 3, worth.min(), worth.mean(), seconds
    except Exception as refusal:  # what the binding raises
        print(f"  gmsh, algorithm {algorithm}, recombination {recombination}: {refusal}", file=sys.stderr)
        return None
    finally:
        gmsh.finalize()


def by_midshell(name, size, binary, folder):
    """the same of a whole run, without the import of the solid"""
    script = ROOT / "fixtures/gen" / f"{name}.geo"
    copy = Path(folder) / script.name
    copy.write_text(script.read_text())
    subprocess.run([os.environ.get("MIDSHELL_GMSH", "gmsh"), str(copy), "-0"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    report = Path(folder) / "report.json"
    run = [binary, "mesh", str(copy.with_suffix(".step")), "-o", str(Path(folder) / "mesh.vtu"), "--element", "quad", "--size", str(size), "--threads", "1", "--json", str(report), "--timings"]
    said = subprocess.run(run, capture_output=True, text=True)
    if said.returncode not in (0, 1):
        sys.exit(f"{name}: {said.stderr}")
    quality = json.loads(report.read_text())["quality"]
    jacobian = next(m for m in quality["metrics"] if m["name"] == "quad.scaled_jacobian")
    stages = dict(line.split() for line in said.stdout[said.stdout.index("timings (s)"):].splitlines()[1:] if len(line.split()) == 2)
    meshing = sum(float(stages.get(k, 0)) for k in ("clean", "remesh", "charts", "polish", "quads", "balance"))
    return quality["quads"], quality["triangles"], jacobian["min"], jacobian["mean"], meshing


def table(names, binary):
    lines = ["| fixture | size, mm | by | quads | triangles | scaled Jacobian, least | mean | meshing, s |", "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    won = 0
    for name in names:
        size = PARTS[name]
        print(name, file=sys.stderr, flush=True)
        with tempfile.TemporaryDirectory() as folder:
            ours = by_midshell(name, size, binary, folder)
        theirs = {way: found for way in WAYS if (found := by_gmsh(name, size, *way))}
        # Whoever has the greatest product of least and mean.
        best = max(theirs, key=lambda way: theirs[way][2] * theirs[way][3])
        rows = [("midshell", ours), (f"Gmsh, algorithm {best[0]}, recombination {best[1]} (the best of {len(theirs)})", theirs[best])]
        for by, (quads, triangles, least, mean, seconds) in rows:
            lines.append(f"| {name} | {size} | {by} | {quads} | {triangles} | {least:.3f} | {mean:.3f} | {seconds:.2f} |")
        # To the digits that are shown.
        won += all(round(ours[k], 3) >= round(theirs[best][k], 3) for k in (2, 3))
    return "\n".join(lines) + f"\n\nAt least equal in both, least and mean, on {won} of {len(names)}."


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("names", nargs="*", default=list(PARTS), metavar="NAME")
    p.add_argument("--midshell", default=str(ROOT / "target/release/midshell"), help="the binary")
    p.add_argument("--page", type=Path, help="the page to write into")
    a = p.parse_args()
    text = table(a.names or list(PARTS), a.midshell)
    if not a.page:
        print(text)
        return
    page, marked = a.page.read_text(), re.compile(r"(<!-- quads -->\n).*?(<!-- end of quads -->)", re.S)
    if not marked.search(page):
        sys.exit(f"{a.page} has no markers for quads")
    a.page.write_text(marked.sub(lambda m: f"{m[1]}{text}\n{m[2]}", page))


if __name__ == "__main__":
    main()
