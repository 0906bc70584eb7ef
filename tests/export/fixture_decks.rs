//! The CalculiX deck of every fixture whose facts are met, as `midshell mesh` writes it, reads and solves a static step.

use super::common::{self, Wanted, facts::Facts, step};
use super::deck::{Deck, Solved};
use super::tools::has_calculix;
use glam::DVec3;
use midshell::export::Material;
use std::collections::BTreeSet;
use std::time::Duration;

macro_rules! fixtures {
    (met: [$($name:ident),* $(,)?], unmet: [$($unmet:ident),* $(,)?] $(,)?) => {
        const NAMES: &[&str] = &[$(stringify!($name),)* $(stringify!($unmet)),*];
        $(#[test]
        fn $name() {
            deck_solves(stringify!($name));
        })*
    };
}

for_all_fixtures!(fixtures);

#[test]
fn every_fixture_is_here() {
    let folder = std::fs::read_dir(common::tools::root().join("fixtures")).unwrap();
    let files = folder.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let facts: BTreeSet<String> = files
        .filter_map(|f| f.strip_suffix(".toml").map(str::to_owned))
        .collect();
    let here: BTreeSet<String> = NAMES.iter().map(|&n| n.to_owned()).collect();
    assert_eq!(here, facts);
}

/// Elements are this many times as large as the facts ask for: a deck has to solve, not to converge.
const COARSER: f64 = 2.0;
/// The clamp holds what lies in this share of the part's length, at its lower end: several rows of nodes, so that they need not be kept from turning. (Of a node that is,
/// CalculiX prints no more than a part of the reaction.)
const CLAMP: f64 = 0.2;
/// Of all forces together, N; its direction favours no axis and no plane of symmetry.
const FORCE: DVec3 = DVec3::new(1.0, 2.0, 3.0);

/// Clamps one end of the part and pulls at every corner node of the rest alike, so that a loose piece would fly away.
fn deck_solves(name: &str) {
    if !has_calculix() {
        return;
    }
    let facts = Facts::of(name);
    let folder = common::scratch();
    let inp = folder.path().join("deck.inp");
    let wanted = Wanted {
        size: COARSER * facts.size,
        // Bends still turn by less than CalculiX's 20 degrees at an edge.
        size_curvature: facts.size_curvature,
        threads: 1,
        element: None,
    };
    let mut command = common::tools::with_gmsh(env!("CARGO_BIN_EXE_midshell"));
    command
        .args([
            "mesh",
            "-q",
            "--size",
            &wanted.size.to_string(),
            "--threads",
            "1",
        ])
        .args(
            wanted
                .size_curvature
                .iter()
                .flat_map(|n| ["--size-curvature".to_owned(), n.to_string()]),
        )
        .arg(step::step(name, step::Variant::AsMade))
        .arg("-o")
        .arg(&inp);
    common::tools::run_to(command, Duration::from_secs(300), &[0, 1]);
    let deck = Deck::read(std::fs::read_to_string(&inp).unwrap());

    let (low, high) = deck
        .nodes
        .values()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| {
            (l.min(*p), h.max(*p))
        });
    let extent = (high - low).to_array();
    let along = (0..3)
        .max_by(|&a, &b| extent[a].total_cmp(&extent[b]))
        .unwrap();
    let limit = low[along] + CLAMP * extent[along];
    let (clamped, free): (Vec<usize>, Vec<usize>) = deck
        .nodes
        .keys()
        .partition(|n| deck.nodes[n][along] <= limit);
    let pulled: Vec<usize> = free
        .iter()
        .copied()
        .filter(|n| deck.corners.contains(n))
        .collect();
    let forces: Vec<(usize, DVec3)> = pulled
        .iter()
        .map(|&n| (n, FORCE / pulled.len() as f64))
        .collect();
    let solved = deck.solve(&clamped, 3, &forces);
    let faults = faults(
        &solved,
        &free,
        FORCE,
        most_deflection(extent[along], facts.thickness_range().0),
    );
    assert_eq!(faults, [""; 0], "{name}, {} nodes", deck.nodes.len());
}

/// A cantilever of length L, thickness t and width L / 1000 deflects 4000 F L² / (E t³): no part that holds together is as slender as that.
fn most_deflection(length: f64, thinnest: f64) -> f64 {
    let young = Material::default().young_mpa;
    4000.0 * FORCE.length() * length.powi(2) / (young * thinnest.powi(3))
}

/// What is wrong with a solution in which `free` nodes were pulled by `force` in all.
fn faults(solved: &Solved, free: &[usize], force: DVec3, most: f64) -> Vec<String> {
    let mut faults = Vec::new();
    // The .dat file has seven digits.
    let balanced = (solved.reaction + force).length() <= 1e-4 * force.length();
    if !balanced {
        faults.push(format!(
            "the clamp holds {}, not {}",
            solved.reaction, -force
        ));
    }
    let greatest = free
        .iter()
        .map(|n| solved.displacements[n].length())
        .fold(0.0, f64::max);
    for node in free {
        let moved = solved.displacements[node].length();
        if !(moved.is_finite() && moved <= most) {
            faults.push(format!("node {node} moves by {moved} mm, more than {most}"));
        } else if moved <= 1e-9 * greatest {
            faults.push(format!("node {node} does not move"));
        }
    }
    if free.is_empty() || greatest == 0.0 {
        faults.push("nothing moves".into());
    }
    faults.truncate(5);
    faults
}

/// The check has teeth: each planted fault of a solution is found, and a sound one has none.
#[test]
fn planted_faults_are_seen() {
    let sound = Solved {
        displacements: [(1, DVec3::ZERO), (2, DVec3::X), (3, DVec3::Y)].into(),
        reaction: -FORCE,
    };
    let found = |solved: &Solved| faults(solved, &[2, 3], FORCE, 2.0);
    assert_eq!(found(&sound), [""; 0]);
    let spoil = |change: &dyn Fn(&mut Solved)| {
        let mut solved = sound.clone();
        change(&mut solved);
        found(&solved).join("; ")
    };
    assert!(spoil(&|s| s.reaction *= 1.001).contains("the clamp holds"));
    assert!(spoil(&|s| s.reaction.x = f64::NAN).contains("the clamp holds"));
    for at in [DVec3::splat(f64::NAN), 3.0 * DVec3::X] {
        let far = spoil(&|s| _ = s.displacements.insert(2, at));
        assert!(far.contains("node 2 moves by"), "{far}");
    }
    let still = spoil(&|s| _ = s.displacements.insert(3, DVec3::ZERO));
    assert!(still.contains("node 3 does not move"), "{still}");
}
