use glam::DVec3;
use midshell::medial::Medial;
use midshell::model::brep::*;
use midshell::model::decomposition::Passage;
use midshell::model::ids::*;
use midshell::model::tet_graph::TetGraph;
use midshell::model::tets::Tets;
use midshell::stage::*;
use std::time::Instant;

fn load(path: &str) -> (Brep, Tets) {
    let b = std::fs::read(path).unwrap();
    let mut at = 0;
    let mut u = |n: usize| -> Vec<u32> {
        let r = b[at..at + 4 * n]
            .chunks(4)
            .map(|c| u32::from_le_bytes(c.try_into().unwrap()))
            .collect();
        at += 4 * n;
        r
    };
    let h = u(5);
    let mut d = |n: usize| -> Vec<DVec3> {
        let r: Vec<u32> = u(n * 6);
        r.chunks(6)
            .map(|c| {
                let f = |i: usize| {
                    f64::from_bits(u64::from(c[2 * i]) | (u64::from(c[2 * i + 1]) << 32))
                };
                DVec3::new(f(0), f(1), f(2))
            })
            .collect()
    };
    let verts = d(h[0] as usize);
    let _ = &mut d;
    let tri = u(3 * h[1] as usize);
    let mut d = |n: usize| -> Vec<DVec3> {
        let r: Vec<u32> = u(n * 6);
        r.chunks(6)
            .map(|c| {
                let f = |i: usize| {
                    f64::from_bits(u64::from(c[2 * i]) | (u64::from(c[2 * i + 1]) << 32))
                };
                DVec3::new(f(0), f(1), f(2))
            })
            .collect()
    };
    let mids = d(3 * h[1] as usize);
    let fid = u(h[1] as usize);
    let tet = u(4 * h[2] as usize);
    let tags = u(h[3] as usize);
    let mut faces: Vec<Face> = tags
        .iter()
        .map(|&t| Face {
            tag: t as i32,
            ..Face::default()
        })
        .collect();
    let mut curves = Vec::new();
    for _ in 0..h[4] {
        let c = u(3);
        let fs = u(c[1] as usize);
        let s = u(2 * c[2] as usize);
        let id = CurveId(curves.len() as u32);
        for &f in &fs {
            faces[f as usize].curves.push(id);
        }
        curves.push(Curve {
            tag: c[0] as i32,
            faces: fs.into_iter().map(FaceId).collect(),
            segments: s
                .chunks(2)
                .map(|x| [VertexId(x[0]), VertexId(x[1])])
                .collect(),
        });
    }
    let facets: Vec<Facet> = (0..h[1] as usize)
        .map(|i| Facet {
            corners: [0, 1, 2].map(|k| VertexId(tri[3 * i + k])),
            mids: [0, 1, 2].map(|k| mids[3 * i + k]),
            face: FaceId(fid[i]),
        })
        .collect();
    (
        Brep {
            solid_tag: 1,
            vertices: verts.into(),
            facets: facets.into(),
            faces: faces.into(),
            curves: curves.into(),
        },
        Tets {
            cells: tet
                .chunks(4)
                .map(|c| [0, 1, 2, 3].map(|k| VertexId(c[k])))
                .collect::<Vec<_>>()
                .into(),
        },
    )
}

fn dump(path: &str, x: &midshell::model::complex::MidComplex) {
    let mut s = String::from("# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n");
    s += &format!("POINTS {} double\n", x.nodes.len());
    for n in &x.nodes {
        s += &format!("{} {} {}\n", n.point.x, n.point.y, n.point.z);
    }
    s += &format!("CELLS {} {}\n", x.triangles.len(), 4 * x.triangles.len());
    for t in &x.triangles {
        s += &format!("3 {} {} {}\n", t.nodes[0].0, t.nodes[1].0, t.nodes[2].0);
    }
    s += &format!("CELL_TYPES {}\n", x.triangles.len());
    for _ in &x.triangles {
        s += "5\n";
    }
    s += &format!(
        "CELL_DATA {}\nSCALARS wall int 1\nLOOKUP_TABLE default\n",
        x.triangles.len()
    );
    for t in &x.triangles {
        s += &format!("{}\n", t.wall.0);
    }
    std::fs::write(path, s).unwrap();
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let (brep, tets) = load(&args[1]);
    let t0 = Instant::now();
    let verbose = args.len() > 2;
    if verbose {
        println!(
            "faults {:?} {:?}",
            brep.check().len(),
            tets.check(brep.vertices.len()).len()
        );
    }
    let graph = TetGraph::new(&tets);
    let tg = t0.elapsed();
    let aag = adjacency::adjacency(&brep);
    let sightings = pair::sight(&brep);
    let ts = t0.elapsed();
    let mut edges: Vec<_> = brep
        .facets
        .iter()
        .flat_map(|f| {
            (0..3).map(|k| {
                let (a, b) = (f.corners[k], f.corners[(k + 1) % 3]);
                (a.min(b), a.max(b))
            })
        })
        .collect();
    edges.sort();
    edges.dedup();
    let mut bv: Vec<_> = brep.facets.iter().flat_map(|f| f.corners).collect();
    bv.sort();
    bv.dedup();
    let want = (bv.len() as i64 - edges.len() as i64 + brep.facets.len() as i64) / 2;
    let mut line = String::new();
    for width in [1.0, 0.5, 0.25, 2.0] {
        let p = pair::pair(
            &brep,
            &aag,
            &sightings,
            &pair::PairOptions {
                least_width: width,
                ..Default::default()
            },
        );
        let roles = role::roles(&aag, &p);
        let dec = decompose::decompose(&brep, &graph, &p, &roles);
        let mut protected: IndexVec<TetEdgeId, bool> =
            dec.passage.iter().map(|&x| x != Passage::Along).collect();
        let grade: IndexVec<TetEdgeId, u8> = dec
            .passage
            .iter()
            .map(|&x| match x {
                Passage::Along => 0,
                Passage::Apart => 1,
                Passage::Through => 2,
            })
            .collect();
        let mut c = collapse::collapse(&graph, brep.vertices.len(), &protected, &grade);
        let mut rounds = 0;
        let bars0 = c.bars.len();
        while rounds < 10 {
            let more = widen::widen(&graph, &c, &grade);
            if more.is_empty() {
                break;
            }
            for e in more {
                protected[e] = true;
            }
            c = collapse::collapse(&graph, brep.vertices.len(), &protected, &grade);
            rounds += 1;
        }
        let tc = t0.elapsed();
        let medial = Medial::new(&brep, &aag, &p);
        let (walls, adopted) = extract::cell_walls(&brep, &graph, &p, &dec, &c.cells, &medial);
        let x = extract::extract(&brep, &graph, &p, &walls, &medial);
        let (x, p) = unite::unite(x, p, &medial);
        let medial = Medial::new(&brep, &aag, &p);
        let x = extract::place(x, &medial);
        let te = t0.elapsed();
        let ok = x.euler() == want && x.pieces() == 1;
        let a = assess::assess(&brep, &sightings, &x);
        line += &format!(
            " | cover {:.3} astray {:.3} t {:.2} w{width:.2} {} chi {}/{want} pc {} bars {bars0}->{} r{rounds} adopt {} walls {} tris {}",
            a.cover,
            a.astray,
            t0.elapsed().as_secs_f64(),
            if ok { "OK " } else { "BAD" },
            x.euler(),
            x.pieces(),
            c.bars.len(),
            adopted,
            p.walls.len(),
            x.triangles.len()
        );
        if verbose && (args.len() < 4 || args[3].parse::<f64>().unwrap() == width) {
            println!(
                "times graph {tg:?} sight {ts:?} collapse {tc:?} extract {te:?}; check {:?}",
                x.check().len()
            );
            for q in &p.pairs {
                println!(
                    "pair {:?} tags {} {} overlap {:.1} of {:.1} {:.1} t {:?} wall {:?}",
                    q.faces,
                    brep.faces[q.faces[0]].tag,
                    brep.faces[q.faces[1]].tag,
                    q.overlap,
                    aag.area[q.faces[0]],
                    aag.area[q.faces[1]],
                    q.thickness,
                    q.wall
                );
            }
            for f in brep.faces.ids() {
                println!(
                    "{f:?} role {:?} carries {:?} side {:?}",
                    roles.role[f], roles.carries[f], p.side[f]
                );
            }
            println!(
                "pairs {} peaks {:?} conflicts {:?}",
                p.pairs.len(),
                p.peaks,
                p.check().len()
            );
            let th: Vec<f64> = x
                .triangles
                .iter()
                .map(|t| {
                    use midshell::geom::placer::Placer;
                    let c = t.nodes.iter().map(|&n| x.nodes[n].point).sum::<DVec3>() / 3.0;
                    medial.thickness(c, t.wall).unwrap_or(0.0).max(1e-6)
                })
                .collect();
            let mut s =
                String::from("# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n");
            s += &format!("POINTS {} double\n", x.nodes.len());
            for n in &x.nodes {
                s += &format!("{} {} {}\n", n.point.x, n.point.y, n.point.z);
            }
            s += &format!("CELLS {} {}\n", x.triangles.len(), 4 * x.triangles.len());
            for t in &x.triangles {
                s += &format!("3 {} {} {}\n", t.nodes[0].0, t.nodes[1].0, t.nodes[2].0);
            }
            s += &format!("CELL_TYPES {}\n", x.triangles.len());
            for _ in &x.triangles {
                s += "5\n";
            }
            s += &format!(
                "CELL_DATA {}\nSCALARS wall int 1\nLOOKUP_TABLE default\n",
                x.triangles.len()
            );
            for t in &x.triangles {
                s += &format!("{}\n", t.wall.0);
            }
            s += "SCALARS thickness double 1\nLOOKUP_TABLE default\n";
            for t in &th {
                s += &format!("{}\n", t);
            }
            std::fs::write(&args[2], s).unwrap();
        }
        if verbose {
            use midshell::geom::placer::Placer;
            let sizing = size::sizing(
                &brep,
                &p,
                std::env::var("H").ok().map(|h| h.parse().unwrap()),
                None,
            );
            let field = |q: DVec3, w: WallId| {
                sizing.at(medial.curvature_radius(q, w), medial.mean_thickness(w))
            };
            let t1 = Instant::now();
            let base = args[2].trim_end_matches(".vtk");
            let (f, st) = fair::fair(x.clone(), &medial);
            println!("fair {st:?} {:?}", t1.elapsed());
            dump(&format!("{base}_fair.vtk"), &f);
            let m = remesh::merge_strips(f, &|w| medial.mean_thickness(w), &medial);
            println!("strips {:?} tris {}", t1.elapsed(), m.triangles.len());
            let (m, st) = fair::fair(m, &medial);
            println!("fair {st:?} {:?}", t1.elapsed());
            dump(&format!("{base}_fair2.vtk"), &m);
            let c = remesh::clean(m, &|q, w| sizing.speck(field(q, w)), &medial);
            println!("clean {:?} tris {}", t1.elapsed(), c.triangles.len());
            dump(&format!("{base}_clean.vtk"), &c);
            let (r, st) = remesh::remesh(c, &field, &medial, &Default::default());
            println!(
                "remesh {st:?} {:?} tris {} size {}",
                t1.elapsed(),
                r.triangles.len(),
                sizing.target
            );
            dump(&format!("{base}_remesh.vtk"), &r);
            let _ = medial.thickness(DVec3::ZERO, WallId(0));
        }
        if verbose && args.len() < 4 {
            break;
        }
    }
    println!(
        "{} tets {} {:.2}s {line}",
        args[1].rsplit('/').next().unwrap(),
        tets.cells.len(),
        t0.elapsed().as_secs_f64()
    );
}
