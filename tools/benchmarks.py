#!/usr/bin/env python3
"""Runs midshell over CAD parts and writes what came of it into a Markdown page, between its markers.

    tools/with-tools.sh python3 tools/benchmarks.py --parts PATH... [--time PART...] [--quads PATH...] [--page docs/benchmarks.md]

PATH is a CAD file or a folder of them. --time names parts that are timed alone, by stage, beside `gmsh PART -2` at the same size in the same run.
Without --page the tables are printed. --verdicts FILE adds the judgement of a judge of your own: a CSV file with the columns `part` (the
file's stem) and `verdict`; where that begins with `right` the mesh is right, whatever midshell says of it. Needs Python 3.9, nothing else.
"""
import argparse
import csv
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ENDINGS = (".step", ".stp", ".iges", ".igs", ".brep")
# As in the README: what an exit status means.
STATUS = {0: "right by its own audit", 1: "doubted", 3: "input refused", 4: "no thin wall", 5: "gmsh failed", 6: "not writable", 70: "internal error"}


def parts_of(paths):
    found = []
    for path in map(Path, paths):
        inside = sorted(path.iterdir()) if path.is_dir() else [path]
        found += [p for p in inside if p.suffix.lower() in ENDINGS]
    if not found:
        sys.exit(f"no CAD parts in {', '.join(paths)}")
    return found


def first_cause(stderr):
    """the cause that midshell gives when it writes nothing"""
    for line in stderr.splitlines():
        if line.strip().startswith("cause:"):
            return line.split("cause:", 1)[1].strip()
    return (stderr.strip().splitlines() or ["no message"])[-1]


def mesh(part, a, folder, *more):
    """one run: exit status (None: out of time), seconds, report, what was said on both streams"""
    report = Path(folder) / f"{part.stem}.json"
    out = Path(folder) / f"{part.stem}.vtu"
    command = [a.midshell, "mesh", str(part), "-o", str(out), "--json", str(report), *more]
    began = time.monotonic()
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=a.limit)
    except subprocess.TimeoutExpired:
        return None, a.limit, {}, "", f"still running after {a.limit:g} s"
    seconds = time.monotonic() - began
    told = json.loads(report.read_text()) if report.exists() else {}
    return run.returncode, seconds, told, run.stdout, run.stderr


def corpus_row(part, a, folder):
    status, seconds, told, _, said = mesh(part, a, folder, "-q", "--threads", str(a.threads))
    print(f"{part.stem}: {status} in {seconds:.1f} s", file=sys.stderr, flush=True)
    audit = told.get("audit", {})
    verdict = audit.get("verdict", {})
    doubts = verdict.get("doubted", []) if isinstance(verdict, dict) else []
    if status is None:
        why = said
    elif status == 1:
        why = ", ".join(f"{d['code']} {d['value']:.3g}, limit {d['limit']:.3g}" for d in doubts)
    else:
        why = "" if status == 0 else first_cause(said).replace(str(part), part.name)
    return dict(part=part.stem, status=status, seconds=seconds, audit=audit, elements=told.get("quality", {}).get("elements"), doubts=[d["code"] for d in doubts], why=why)


def judged_rows(path):
    """rows that a judge of one's own has written while it ran midshell itself: part, exit, seconds, chi, chi_solid, pieces, solids, r95, cover, mass, elements, why, verdict"""
    number = lambda text: float(text) if text not in (None, "", "-") else None
    rows, verdicts = [], {}
    with open(path, newline="") as f:
        for r in csv.DictReader(f):
            status = int(r["exit"]) if r["exit"].lstrip("-").isdigit() else None
            audit = {}
            if number(r["chi"]) is not None:
                audit = dict(euler=round(number(r["chi"])), euler_solid=number(r["chi_solid"]), pieces=number(r["pieces"]), solids=number(r["solids"]))
                audit |= {k: number(r[k]) for k in ("r95", "cover", "mass")}
            r["why"] = r["why"].strip()
            why = "" if status == 0 else r["why"] or f"still running after {number(r['seconds']):g} s" if status is None else r["why"]
            # The last line of what midshell said begins with the doubt's name.
            doubts = [why.split(":", 1)[0]] if status == 1 else []
            rows.append(dict(part=r["part"], status=status, seconds=number(r["seconds"]), audit=audit, elements=round(number(r["elements"])) if number(r["elements"]) else None, doubts=doubts, why=why.split(": ", 1)[-1] if status not in (0, 1) else ", ".join(doubts)))
            verdicts[r["part"]] = r["verdict"]
    return rows, verdicts


def percent(x, digits=2):
    return "-" if x is None else f"{100 * x:.{digits}f} %"


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(c).replace("|", "/") for c in line) + " |" for line in lines)


def topology_right(row):
    audit = row["audit"]
    return bool(audit) and audit["euler"] == audit["euler_solid"] and audit["pieces"] == audit["solids"]


def causes_of(rows, verdicts):
    """why parts are not right, with their number"""
    causes = Counter()
    for r in rows:
        if r["status"] == 1:
            causes.update(("doubted: " + code) for code in r["doubts"])
        elif r["status"] is None:
            causes["out of time"] += 1
        elif r["status"] != 0:
            causes[STATUS.get(r["status"], f"status {r['status']}")] += 1
        if verdicts and r["status"] == 0 and not verdicts.get(r["part"], "").startswith("right"):
            causes["not right by the separate judge, though not doubted"] += 1
    return causes


def earlier_of(page):
    """the counts of an earlier state that a page already sets beside its own: causes, and how many were right"""
    right = re.search(r"right by the separate judge: (\d+) before", page)
    block = re.search(r"\| cause \| parts before \| parts after \|\n.*?\n\n", page, re.S)
    if not (right and block):
        return None
    lines = [line.strip("| ").split(" | ") for line in block[0].strip().splitlines()[2:]]
    return Counter({cause: int(count) for cause, count, _ in lines}), int(right[1])


def corpus_text(rows, verdicts, before=None):
    n = len(rows)
    share = lambda test: f"{sum(map(test, rows))} of {n} ({100 * sum(map(test, rows)) / n:.0f} %)"
    summary = [["right by their own audit (status 0)", share(lambda r: r["status"] == 0)],
               ["meshed, but doubted (status 1)", share(lambda r: r["status"] == 1)],
               ["refused or failed", share(lambda r: r["status"] not in (0, 1))],
               ["topology of the solid (Euler characteristic, pieces)", share(topology_right)]]
    if verdicts:
        right = lambda r: verdicts.get(r["part"], "").startswith("right")
        summary += [["right by the separate judge", share(right)],
                    ["right by their own audit, not by the separate judge", share(lambda r: r["status"] == 0 and not right(r))]]
    seconds = [r["seconds"] for r in rows]
    summary.append(["seconds a part: median, worst", f"{statistics.median(seconds):.1f}, {max(seconds):.1f}"])
    causes = causes_of(rows, verdicts)
    def line(r):
        audit = r["audit"]
        euler = f"{audit['euler']} / {audit['euler_solid']:g}" if audit else "-"
        cells = [r["part"], "-" if r["status"] is None else r["status"], euler, percent(audit.get("r95")), percent(audit.get("cover"), 1), percent(audit.get("mass")), r["elements"] or "-", f"{r['seconds']:.1f}", r["why"]]
        return cells + ([verdicts.get(r["part"], "-")] if verdicts else [])
    head = ["part", "status", "Euler mesh / solid", "R-error 95 %", "covered", "mass off", "elements", "s", "why not"]
    failing = [r for r in rows if r["status"] != 0 or (verdicts and not verdicts.get(r["part"], "").startswith("right"))]
    good = [r for r in rows if r not in failing]
    head += ["judge"] if verdicts else []
    blocks = [table(["outcome", "parts"], summary)]
    if before:
        then, right_then = before
        names = sorted(causes | then, key=lambda name: (-then[name], -causes[name], name))
        right = lambda of: sum(v.startswith("right") for v in of.values())
        blocks += [f"Causes, before and after (a part may have several; right by the separate judge: {right_then} before, {right(verdicts)} after):"]
        blocks += [table(["cause", "parts before", "parts after"], [[name, then[name], causes[name]] for name in names])]
    elif causes:
        blocks += ["Causes (a part may have several):", table(["cause", "parts"], causes.most_common())]
    if causes:
        blocks += ["Parts that are not right:", table(head, map(line, sorted(failing, key=lambda r: (str(r["status"]), r["why"], r["part"]))))]
    if good:
        blocks += ["Parts that are:", table(head, map(line, good))]
    return "\n\n".join(blocks)


def quads_row(part, a, folder):
    status, seconds, told, _, said = mesh(part, a, folder, "-q", "--threads", str(a.threads), "--element", "quad")
    print(f"{part.stem} in quads: {status} in {seconds:.1f} s", file=sys.stderr, flush=True)
    if not told:
        return dict(part=part.stem, status=status, why=said if status is None else first_cause(said).replace(str(part), part.name))
    quality = told["quality"]
    jacobian = next(m for m in quality["metrics"] if m["name"] == "quad.scaled_jacobian")
    low, high = jacobian["histogram_range"]
    bins = jacobian["histogram"]
    good = sum(count for i, count in enumerate(bins) if low + (high - low) * i / len(bins) >= 0.7 - 1e-9)
    return dict(part=part.stem, status=status, quads=quality["quads"], triangles=quality["triangles"], least=jacobian["min"], mean=jacobian["mean"], good=good, passed=quality["pass_share"], seconds=seconds)


def quads_text(rows):
    """how good meshes of quads are, over all parts and part by part"""
    made = [r for r in rows if "quads" in r]
    # Where the audit doubts a mesh a solver should not get it, whatever its elements are.
    groups = [made, [r for r in made if r["status"] == 0]]

    def summed(group):
        quads, triangles = (sum(r[k] for r in group) for k in ("quads", "triangles"))
        total = max(1, quads + triangles)
        return [f"{len(group)} of {len(rows)}",
                percent(sum(r["good"] for r in group) / max(1, quads)),
                f"{min(r['least'] for r in group):.3f}",
                f"{statistics.mean(r['mean'] for r in group):.3f}",
                percent(triangles / total),
                percent(sum(r["passed"] * (r["quads"] + r["triangles"]) for r in group) / total)]

    names = ["parts", "quads with a scaled Jacobian of 0.7 or more", "least scaled Jacobian of a quad", "mean scaled Jacobian, mean of the parts", "triangles among the elements", "elements within profile `shell`"]
    summary = zip(names, *(summed(g) for g in groups if g))
    line = lambda r: [r["part"], r["status"], r["quads"], r["triangles"], f"{r['least']:.3f}", f"{r['mean']:.3f}", percent(r["good"] / max(1, r["quads"])), percent(r["passed"])]
    head = ["part", "status", "quads", "triangles", "scaled Jacobian, least", "mean", "0.7 or more", "within profile `shell`"]
    blocks = [table(["", "all that are meshed", "right by their own audit"][: 1 + sum(map(bool, groups))], summary), table(head, map(line, made))]
    lost = [r for r in rows if "quads" not in r]
    if lost:
        blocks.append("Not meshed: " + "; ".join(f"{r['part']} ({r['why']})" for r in lost))
    return "\n\n".join(blocks)


def triangles_row(part, a, folder):
    status, seconds, told, _, said = mesh(part, a, folder, "-q", "--threads", str(a.threads))
    print(f"{part.stem} in triangles: {status} in {seconds:.1f} s", file=sys.stderr, flush=True)
    if not told:
        return dict(part=part.stem, status=status, why=said if status is None else first_cause(said).replace(str(part), part.name))
    quality = told["quality"]
    least = next(m for m in quality["metrics"] if m["name"] == "triangle.min_angle_deg")["min"]
    return dict(part=part.stem, status=status, triangles=quality["triangles"], passed=quality["pass_share"], least=least, failures=dict(quality["failures"]))


def triangles_text(rows):
    """how many triangles break which criterion, over all parts and part by part"""
    made = [r for r in rows if "triangles" in r]
    total = max(1, sum(r["triangles"] for r in made))
    broken = Counter()
    for r in made:
        broken.update(r["failures"])
    summary = [["parts meshed", f"{len(made)} of {len(rows)}"], ["triangles", total],
               ["within profile `shell`", percent(sum(r["passed"] * r["triangles"] for r in made) / total)]]
    summary += [[f"beyond the limit of {name}", percent(count / total)] for name, count in broken.most_common()]
    line = lambda r: [r["part"], r["status"], r["triangles"], percent(r["passed"]), f"{r['least']:.1f}"]
    return "\n\n".join([table(["all parts", ""], summary), table(["part", "status", "triangles", "within profile `shell`", "least angle, deg"], map(line, made))])


def gmsh_seconds(part, size, folder):
    """wall time and elements of `gmsh PART -2` with this size as the greatest, in one thread"""
    gmsh = os.environ.get("MIDSHELL_GMSH", "gmsh")
    beside = os.pathsep.join([str(Path(gmsh).parent), os.environ.get("PATH", "")])
    command = [gmsh, str(part), "-2", "-nt", "1", "-clmax", f"{size:.12g}", "-setstring", "Geometry.OCCTargetUnit", "MM", "-o", str(Path(folder) / "surface.msh")]
    began = time.monotonic()
    run = subprocess.run(command, capture_output=True, text=True, env=dict(os.environ, PATH=beside), check=True)
    counts = re.findall(r"(\d+) nodes (\d+) elements", run.stdout)
    return time.monotonic() - began, counts[-1][1] if counts else "-"


def timing_text(parts, a, folder):
    rows, stages = [], {}
    for part in parts:
        status, seconds, told, said, err = mesh(part, a, folder, "--timings", "--threads", "1")
        if status not in (0, 1):
            sys.exit(f"{part}: {first_cause(err)}")
        size = told["solids"][0]["size"]
        lines = said[said.index("timings (s)"):].splitlines()[1:]
        stages[part.stem] = {name: float(s) for name, s in (line.split() for line in lines if len(line.split()) == 2)}
        other, count = gmsh_seconds(part, size, folder)
        most = told["peak_memory"]
        memory = [f"{most[k] / 2**20:.0f}" if most.get(k) else "-" for k in ("own_bytes", "child_bytes")]
        rows.append([part.stem, f"{size:.3g}", told["quality"]["elements"], f"{seconds:.2f}", count, f"{other:.2f}", f"{seconds / other:.1f}", *memory])
    head = ["part", "size, mm", "elements", "midshell, s", "elements of `gmsh -2`", "`gmsh -2`, s", "ratio", "most memory, MiB", "gmsh (in its own process), MiB"]
    names = list(dict.fromkeys(name for s in stages.values() for name in s))
    by_stage = [[name, *(f"{s.get(name, 0.0):.3f} ({100 * s.get(name, 0.0) / max(s['total'], 1e-9):.0f} %)" for s in stages.values())] for name in names]
    return table(head, rows) + "\n\nSeconds by stage:\n\n" + table(["stage", *stages], by_stage)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--parts", nargs="+", default=[], help="CAD files or folders of them")
    p.add_argument("--time", nargs="+", default=[], help="parts to time by stage, beside gmsh")
    p.add_argument("--quads", nargs="+", default=[], help="parts, or folders of them, to mesh in quads")
    p.add_argument("--triangles", nargs="+", default=[], help="parts, or folders of them, whose triangles are held against the criteria")
    p.add_argument("--midshell", default=str(ROOT / "target/release/midshell"), help="the binary")
    p.add_argument("--page", type=Path, help="the page to write into")
    p.add_argument("--verdicts", type=Path, help="CSV of a judge of your own: part, verdict")
    p.add_argument("--results", type=Path, help="CSV of a judge that ran midshell itself, instead of --parts and --verdicts")
    p.add_argument("--before", type=Path, help="with --results: such a file of an earlier state, to set the causes side by side; left out, what the page has of one stays")
    p.add_argument("--jobs", type=int, default=2, help="parts at a time")
    p.add_argument("--threads", type=int, default=2, help="threads a part")
    p.add_argument("--limit", type=float, default=120, help="seconds a part")
    a = p.parse_args()
    if not (a.parts or a.time or a.results or a.quads or a.triangles):
        p.error("nothing to do: name --parts, --results, --quads, --triangles or --time")
    texts = {}
    page = a.page.read_text() if a.page else ""
    with tempfile.TemporaryDirectory() as folder:
        # Timed first and alone: nothing else runs meanwhile.
        if a.time:
            texts["timings"] = timing_text(parts_of(a.time), a, folder)
        if a.results:
            before = earlier_of(page)
            if a.before:
                rows, verdicts = judged_rows(a.before)
                before = causes_of(rows, verdicts), sum(v.startswith("right") for v in verdicts.values())
            texts["corpus"] = corpus_text(*judged_rows(a.results), before)
        elif a.parts:
            verdicts = {}
            if a.verdicts:
                with open(a.verdicts, newline="") as f:
                    verdicts = {row["part"]: row["verdict"] for row in csv.DictReader(f)}
            with ThreadPoolExecutor(a.jobs) as pool:
                rows = list(pool.map(lambda part: corpus_row(part, a, folder), parts_of(a.parts)))
            texts["corpus"] = corpus_text(rows, verdicts)
        if a.quads:
            with ThreadPoolExecutor(a.jobs) as pool:
                texts["quad corpus"] = quads_text(list(pool.map(lambda part: quads_row(part, a, folder), parts_of(a.quads))))
        if a.triangles:
            with ThreadPoolExecutor(a.jobs) as pool:
                texts["triangle corpus"] = triangles_text(list(pool.map(lambda part: triangles_row(part, a, folder), parts_of(a.triangles))))
    for name, text in texts.items():
        marked = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)", re.S)
        if not a.page:
            print(text + "\n")
        elif not marked.search(page):
            sys.exit(f"{a.page} has no markers for {name}")
        else:
            page = marked.sub(lambda m: f"{m[1]}{text}\n{m[2]}", page)
    if a.page:
        a.page.write_text(page)


if __name__ == "__main__":
    main()
