#!/usr/bin/env python3
"""Meshes of quads beside Gmsh's, on the same mid-surfaces at the same size, as a table in a Markdown page, between its markers.

    tools/with-tools.sh .venv/bin/python3 tools/quads_beside_gmsh.py [--page docs/benchmarks.md] [NAME ...]
    tools/with-tools.sh .venv/bin/python3 tools/quads_beside_gmsh.py [--page docs/benchmarks.md] --parts FILE ...

midshell gets the solid of each fixture (`--element quad`); Gmsh gets its mid-surface as CAD faces, drawn by hand in tests/python/measure_ideal.py, and meshes it with
every algorithm that makes quads (6 frontal, 8 frontal for quads, 9 packing of parallelograms) and both recombinations (1 blossom, 3 blossom full-quad). Scaled Jacobians
are Verdict's, of all quads; triangles are counted beside them.

Of other parts (`--parts`, CAD files) nobody has drawn the mid-surface: Gmsh gets midshell's triangles of it as discrete faces and curves (tools/mid_surface_in_gmsh.py), and sizes in two
ways, those of midshell's quads from place to place, and the same everywhere, scaled until there are about as many elements. Each run has a process of its own and a limit of time.
"""
import argparse
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import gmsh
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/python"))
import measure_ideal  # noqa: E402
import measure_vtu  # noqa: E402
import mid_surface_in_gmsh as discrete  # noqa: E402

# Flat ones and curved ones, with holes, junctions and creases; sizes as coarse as an analyst would take.
PARTS = {"plate_web": 5, "plate_holes": 4, "t_sharp": 4, "open_box": 5, "egg_crate": 5, "ribs_crossing": 4, "slots": 4, "tube": 4, "tubes_t": 4}
WAYS = [(algorithm, recombination) for algorithm in (6, 8, 9) for recombination in (1, 3)]


# Triangles of a mid-surface for Gmsh: elements in a full turn, so that creases and corners stand out from bends.
TURN = 36
# Gmsh at times leaves parts of a face out, or covers them twice. Chords of coarse meshes change the area by a percent.
AREA = 0.03
# Sizes are scaled, in up to so many runs, until Gmsh makes about as many elements as midshell; a mesh with many more or fewer does not count.
RUNS, NEAR, FAR = 4, 1.1, 1.5
HEAD = ["by", "quads", "triangles", "scaled Jacobian, least", "mean", "meshing, s"]


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
        points, tris, quads = discrete.mesh_in_gmsh()
        worth = discrete.jacobians(points[quads]) if len(quads) else np.zeros(1)
        return len(quads), len(tris), worth.min(), worth.mean(), seconds
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
    _, quality, meshing = run_midshell(copy.with_suffix(".step"), binary, folder, "--element", "quad", "--size", str(size))
    jacobian = next(m for m in quality["metrics"] if m["name"] == "quad.scaled_jacobian")
    return quality["quads"], quality["triangles"], jacobian["min"], jacobian["mean"], meshing


class NoMesh(Exception):
    """midshell made none"""


def run_midshell(part, binary, folder, *options):
    """the mesh, the quality in the report, seconds of meshing"""
    report, out = Path(folder) / "report.json", Path(folder) / "mesh.vtu"
    said = subprocess.run([binary, "mesh", str(part), "-o", str(out), *options, "--threads", "1", "--json", str(report), "--timings"], capture_output=True, text=True)
    if said.returncode not in (0, 1):
        raise NoMesh(f"{part}: midshell ends with status {said.returncode}\n{said.stderr}")
    stages = dict(line.split() for line in said.stdout[said.stdout.index("timings (s)"):].splitlines()[1:] if len(line.split()) == 2)
    meshing = sum(float(stages.get(k, 0)) for k in ("clean", "remesh", "charts", "polish", "quads", "balance"))
    return measure_vtu.read(out), json.loads(report.read_text())["quality"], meshing


def sizes_of(mesh):
    """sizes at the nodes of a mesh of quads (sides of squares as large as the quads there; a triangle is half a quad), and the size at which as many squares cover it"""
    tri, quad = discrete.areas(mesh.points, mesh.tris, mesh.quads)
    area, number = np.zeros(len(mesh.points)), np.zeros(len(mesh.points))
    for cells, each in ((mesh.quads, quad), (mesh.tris, 2 * tri)):
        np.add.at(area, cells, each[:, None])
        np.add.at(number, cells, 1)
    return np.sqrt(area / np.maximum(number, 1)), ((quad.sum() + tri.sum()) / (len(quad) + len(tri) / 2)) ** 0.5


def ways_on_part(part, a, folder):
    """(ours, ways of Gmsh that made a mesh, why the others made none)"""
    mesh, _, seconds = run_midshell(part, a.midshell, folder, "--element", "quad")
    worth = discrete.jacobians(mesh.points[mesh.quads]) if len(mesh.quads) else np.zeros(1)
    ours = len(mesh.quads), len(mesh.tris), worth.min(), worth.mean(), seconds
    print(f"  midshell: {told(ours)}", file=sys.stderr, flush=True)
    if a.keep:
        (Path(folder) / "mesh.vtu").rename(a.keep / f"{part.stem}.vtu")
    at, even = sizes_of(mesh)
    corners = np.concatenate([mesh.quads[:, :3], mesh.quads[:, [0, 2, 3]], mesh.tris])
    np.savez(Path(folder) / "sizes.npz", corners=mesh.points[corners], at=at[corners])
    fine, _, _ = run_midshell(part, a.midshell, folder, "--size-curvature", str(TURN))
    geometry = Path(folder) / "mid-surface.msh"
    faces, curves = discrete.write(geometry, fine.points, fine.tris, fine.cell_data["sheet"][fine.tri_cells], even)
    print(f"  {len(fine.tris)} triangles, {faces} faces, {curves} curves", file=sys.stderr, flush=True)
    theirs, failed = {}, {}
    for size, sizes in ((None, "sizes of ours"), (even, "one size")):
        for way in WAYS:
            job = dict(geometry=str(geometry), sizes=str(Path(folder) / "sizes.npz"), algorithm=way[0], recombination=way[1], size=size)
            if a.keep:
                job["out"] = str(a.keep / f"{part.stem}-{way[0]}-{way[1]}-{sizes.split()[0]}.vtu")
            found, why = scaled(job, ours[0] + ours[1], folder, a.limit)
            if why:
                failed[(*way, sizes)] = why
            else:
                theirs[(*way, sizes)] = found
            print(f"  gmsh, algorithm {way[0]}, recombination {way[1]}, {sizes}: {why or told(found)}", file=sys.stderr, flush=True)
    return ours, theirs, failed


def scaled(job, wanted, folder, limit):
    """`attempt` with the scale of sizes at which as many elements come out as are wanted, or nearly so"""
    nearest, scale = (None, "not started"), 1.0
    for _ in range(RUNS):
        divisions = {}
        for _ in range(RUNS):
            found, why, odd = attempt({**job, "scale": scale, "divisions": list(divisions.items())}, folder, limit)
            if not odd:
                break
            divisions.update(odd)
        off = lambda f: abs(math.log((f[0] + f[1]) / wanted))
        if not nearest[0] or not why and off(found) < off(nearest[0]):
            nearest = found, why
        if why or off(found) < math.log(NEAR):
            break
        scale *= math.sqrt((found[0] + found[1]) / wanted)
    if nearest[0] and off(nearest[0]) > math.log(FAR):
        return None, "too many or too few ({} quads, {} triangles)".format(*nearest[0]) + (f"; scaled: {why}" if why else "")
    return nearest


def attempt(job, folder, limit):
    """(what came of it, None, []), or (None, why nothing did, numbers of sides that may help)"""
    path = Path(folder) / "job.json"
    path.write_text(json.dumps(job))
    try:
        run = subprocess.run([sys.executable, str(ROOT / "tools/mid_surface_in_gmsh.py"), str(path)], capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return None, "out of time", []
    try:
        found = json.loads(run.stdout.strip().splitlines()[-1])
    except (IndexError, ValueError):
        return None, f"crashed (status {run.returncode})", []
    if "refused" in found:
        return None, f"refused ({found['refused']})", found.get("odd", [])
    if "incomplete" in found:
        return None, f"incomplete ({found['incomplete']})", []
    if found["empty"] or not found["quads"] or abs(found["covered"] - 1) > AREA:
        return None, f"incomplete ({found['empty']} faces empty, {found['covered']:.1%} of the area)", []
    return tuple(found[k] for k in ("quads", "triangles", "least", "mean", "seconds")), None, []


def told(found):
    return "{} quads, {} triangles, least {:.3f}, mean {:.3f}, {:.2f} s".format(*found)


def best_of(theirs):
    """who has the greatest product of least and mean, of those whose quads are all convex if there are any"""
    return max(theirs, key=lambda way: (theirs[way][2] > 0, theirs[way][2] * theirs[way][3] if theirs[way][2] > 0 else theirs[way][2]))


def at_least_equal(one, other):
    """in least and mean, to the digits that are shown"""
    return all(round(one[k], 3) >= round(other[k], 3) for k in (2, 3))


def cells_of(found):
    quads, triangles, least, mean, seconds = found
    return f"{quads} | {triangles} | {least:.3f} | {mean:.3f} | {seconds:.2f} |"


def parts_table(a):
    lines = ["| part | " + " | ".join(HEAD) + " |", "| --- |" + " --- |" * len(HEAD)]
    won = over_all = tried = 0
    causes = Counter()
    for part in a.parts:
        print(part.stem, file=sys.stderr, flush=True)
        with tempfile.TemporaryDirectory() as folder:
            try:
                ours, theirs, failed = ways_on_part(part, a, folder)
            except NoMesh as why:
                print(why, file=sys.stderr)
                lines.append(f"| {part.stem} | midshell: no mesh | | | | | |")
                continue
        tried += len(theirs) + len(failed)
        causes.update(why.split(" (")[0] for why in failed.values())
        lines.append(f"| {part.stem} | midshell | {cells_of(ours)}")
        if not theirs:
            lines.append(f"| {part.stem} | Gmsh: no mesh in {len(failed)} ways | | | | | |")
            continue
        best, highest = best_of(theirs), max(theirs, key=lambda way: theirs[way][3])
        lines.append(f"| {part.stem} | Gmsh, {way_of(best)} (the best of {len(theirs)}{f'; {len(failed)} failed' if failed else ''}) | {cells_of(theirs[best])}")
        if highest != best:
            lines.append(f"| {part.stem} | Gmsh, {way_of(highest)} (the highest mean) | {cells_of(theirs[highest])}")
        won += at_least_equal(ours, theirs[best])
        over_all += at_least_equal(ours, (0, 0, *(max(found[k] for found in theirs.values()) for k in (2, 3))))
    both = sum(": no mesh" in line for line in lines)
    said = f"At least equal in both, least and mean, on {won} of {len(a.parts) - both}; on {over_all} also where least and mean may come from different ways of Gmsh."
    if both:
        said += f" Of {both} one of the two made no mesh."
    told_of = ", ".join(f"{n} {why}" for why, n in causes.most_common())
    said += f" Of {tried} ways tried {sum(causes.values()) or 'all'}" + (f" do not count: {told_of}." if causes else " count.")
    return "\n".join(lines) + "\n\n" + said


def way_of(way):
    return f"algorithm {way[0]}, recombination {way[1]}, {way[2]}"


def table(names, binary):
    lines = ["| fixture | size, mm | " + " | ".join(HEAD) + " |", "| --- | --- |" + " --- |" * len(HEAD)]
    won = 0
    for name in names:
        size = PARTS[name]
        print(name, file=sys.stderr, flush=True)
        with tempfile.TemporaryDirectory() as folder:
            try:
                ours = by_midshell(name, size, binary, folder)
            except NoMesh as why:
                sys.exit(str(why))
        theirs = {way: found for way in WAYS if (found := by_gmsh(name, size, *way))}
        best = best_of(theirs)
        lines.append(f"| {name} | {size} | midshell | {cells_of(ours)}")
        lines.append(f"| {name} | {size} | Gmsh, algorithm {best[0]}, recombination {best[1]} (the best of {len(theirs)}) | {cells_of(theirs[best])}")
        won += at_least_equal(ours, theirs[best])
    return "\n".join(lines) + f"\n\nAt least equal in both, least and mean, on {won} of {len(names)}."


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("names", nargs="*", metavar="NAME", help=f"fixtures (default: {', '.join(PARTS)})")
    p.add_argument("--parts", nargs="+", type=Path, default=[], metavar="FILE", help="CAD files, instead of fixtures")
    p.add_argument("--midshell", default=str(ROOT / "target/release/midshell"), help="the binary")
    p.add_argument("--page", type=Path, help="the page to write into")
    p.add_argument("--limit", type=float, default=60, help="with --parts: seconds for each way of Gmsh")
    p.add_argument("--keep", type=Path, help="with --parts: a folder for the meshes of both, as VTU")
    a = p.parse_args()
    if a.names and a.parts:
        p.error("either fixtures or --parts, not both")
    for name in a.names:
        if name not in PARTS:
            p.error(f"no fixture {name}; there are {', '.join(PARTS)}")
    for part in a.parts:
        if not part.is_file():
            p.error(f"no such part: {part}")
    if not os.access(a.midshell, os.X_OK) or not Path(a.midshell).is_file():
        p.error(f"no binary at {a.midshell}: build it (cargo build --release), or name one with --midshell")
    marker = "quad parts" if a.parts else "quads"
    marked = re.compile(rf"(<!-- {marker} -->\n).*?(<!-- end of {marker} -->)", re.S)
    # Before what takes long.
    if a.page and not (a.page.is_file() and marked.search(a.page.read_text())):
        p.error(f"{a.page} has no markers for {marker}")
    if a.keep:
        a.keep.mkdir(parents=True, exist_ok=True)
    text = parts_table(a) if a.parts else table(a.names or list(PARTS), a.midshell)
    if not a.page:
        print(text)
        return
    a.page.write_text(marked.sub(lambda m: f"{m[1]}{text}\n{m[2]}", a.page.read_text()))


if __name__ == "__main__":
    main()
