//! What a reader saw of a file, and how that is held against the mesh that was written.

use midshell::model::shell::ShellMesh;
use serde::Deserialize;
use std::collections::BTreeMap;

type Point = [f64; 3];

/// A mesh as a reader tells it. What the reader does not tell is `None`.
#[derive(Clone, Debug, Deserialize)]
pub struct Seen {
    pub nodes: Vec<SeenNode>,
    pub elements: Vec<SeenElement>,
    pub element_sets: Option<BTreeMap<String, Vec<usize>>>,
    pub node_sets: Option<BTreeMap<String, Vec<usize>>>,
    pub edges: Option<BTreeMap<String, Vec<[Point; 2]>>>,
    pub warnings: Vec<String>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct SeenNode {
    pub number: Option<usize>,
    pub at: Point,
    pub thickness: Option<f64>,
    pub normal: Option<Point>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct SeenElement {
    pub number: Option<usize>,
    pub corners: Vec<Point>,
    pub mean_thickness: Option<f64>,
    pub corner_thickness: Option<Vec<f64>>,
    pub sheet: Option<usize>,
    pub source_faces: Option<[i32; 2]>,
}

/// The truth: the mesh told in full.
pub fn told(mesh: &ShellMesh) -> Seen {
    let number = |n: &midshell::model::ids::NodeId| n.0 as usize + 1;
    let nodes = mesh.nodes.ids().map(|id| SeenNode {
        number: Some(number(&id)),
        at: mesh.nodes[id].to_array(),
        thickness: Some(mesh.node_thickness[id]),
        normal: Some(mesh.node_normals[id].to_array()),
    });
    let elements = mesh.elements.enumerated().map(|(id, element)| {
        let corners = element.corners.as_slice();
        SeenElement {
            number: Some(id.0 as usize + 1),
            corners: corners.iter().map(|&n| mesh.nodes[n].to_array()).collect(),
            mean_thickness: Some(element.mean_thickness()),
            corner_thickness: Some(element.thickness[..corners.len()].to_vec()),
            sheet: Some(element.sheet.0 as usize + 1),
            source_faces: Some(element.source_faces),
        }
    });
    let mut element_sets: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    let mut node_sets: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (id, element) in mesh.elements.enumerated() {
        let sheet = format!("SHEET_{}", element.sheet.0 + 1);
        let faces = element.source_faces.map(|tag| format!("FACE_{tag}"));
        for name in faces.iter().chain([&sheet]) {
            let corners = element.corners.as_slice().iter().map(number);
            node_sets.entry(name.clone()).or_default().extend(corners);
        }
        let solid = format!("SOLID_{}", mesh.sheets[element.sheet].solid_tag);
        let unsure = element.unsure.then(|| "UNSURE".to_owned());
        for name in faces.into_iter().chain([sheet, solid]).chain(unsure) {
            element_sets
                .entry(name)
                .or_default()
                .push(id.0 as usize + 1);
        }
    }
    let mut edges = BTreeMap::new();
    let curves = [
        ("RIM", &mesh.rims),
        ("JUNCTION", &mesh.junctions),
        ("CREASE", &mesh.creases),
    ];
    for (name, of) in curves.into_iter().filter(|(_, of)| !of.is_empty()) {
        node_sets.insert(name.into(), of.iter().flatten().map(number).collect());
        let places = of.iter().map(|edge| edge.map(|n| mesh.nodes[n].to_array()));
        edges.insert(name.to_owned(), places.collect());
    }
    for set in node_sets.values_mut() {
        set.sort_unstable();
        set.dedup();
    }
    Seen {
        nodes: nodes.collect(),
        elements: elements.collect(),
        element_sets: Some(element_sets),
        node_sets: Some(node_sets),
        edges: Some(edges),
        warnings: Vec::new(),
    }
}

/// Everything in which `seen` differs from `truth` by more than `relative`, in words. Numbers, where the reader tells none, are matched by place.
pub fn differences(truth: &Seen, seen: &Seen, relative: f64) -> Vec<String> {
    let mut found: Vec<String> = seen
        .warnings
        .iter()
        .map(|w| format!("warning: {w}"))
        .collect();
    let mut report = |ok: bool, what: String| {
        if !ok {
            found.push(what);
        }
    };
    let near = |a: f64, b: f64| (a - b).abs() <= relative * a.abs();
    let all_near =
        |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| near(*a, *b));
    let same = |a: &[Point], b: &[Point]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| all_near(a, b))
    };
    report(
        truth.nodes.len() == seen.nodes.len(),
        format!("{} nodes, not {}", seen.nodes.len(), truth.nodes.len()),
    );
    for t in &truth.nodes {
        let Some(s) = seen.nodes.iter().find(|s| all_near(&t.at, &s.at)) else {
            report(false, format!("no node at {:?}", t.at));
            continue;
        };
        report(
            s.number.is_none() || s.number == t.number,
            format!("{s:?} is {t:?}"),
        );
        let thickness = s
            .thickness
            .is_none_or(|v| t.thickness.is_some_and(|w| near(w, v)));
        let normal = s
            .normal
            .is_none_or(|v| t.normal.is_some_and(|w| all_near(&w, &v)));
        report(thickness && normal, format!("{s:?} is {t:?}"));
    }
    report(
        truth.elements.len() == seen.elements.len(),
        format!(
            "{} elements, not {}",
            seen.elements.len(),
            truth.elements.len()
        ),
    );
    for t in &truth.elements {
        let Some(s) = seen.elements.iter().find(|s| same(&t.corners, &s.corners)) else {
            report(false, format!("no element with corners {:?}", t.corners));
            continue;
        };
        let mean = s
            .mean_thickness
            .is_none_or(|v| t.mean_thickness.is_some_and(|w| near(w, v)));
        let corners = match (&s.corner_thickness, &t.corner_thickness) {
            (Some(v), Some(w)) => all_near(w, v),
            (v, _) => v.is_none(),
        };
        let rest = (s.number.is_none() || s.number == t.number)
            && (s.sheet.is_none() || s.sheet == t.sheet)
            && (s.source_faces.is_none() || s.source_faces == t.source_faces);
        report(mean && corners && rest, format!("{s:?} is {t:?}"));
    }
    for (t, s) in [
        (&truth.element_sets, &seen.element_sets),
        (&truth.node_sets, &seen.node_sets),
    ] {
        report(s.is_none() || s == t, format!("sets {s:?} are {t:?}"));
    }
    if let (Some(t), Some(s)) = (&truth.edges, &seen.edges) {
        let names = |of: &BTreeMap<String, Vec<[Point; 2]>>| of.keys().cloned().collect::<Vec<_>>();
        report(
            names(t) == names(s),
            format!("curves {:?}, not {:?}", names(s), names(t)),
        );
        for (name, edges) in t {
            let there = s.get(name).map_or(&[][..], Vec::as_slice);
            let all = edges.iter().all(|e| there.iter().any(|f| same(e, f)));
            report(
                all && edges.len() == there.len(),
                format!("{name} {there:?} is {edges:?}"),
            );
        }
    }
    found
}
