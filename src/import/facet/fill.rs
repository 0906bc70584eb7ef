//! Tets inside closed facets, by gmsh: the facets stay as they are.
//!
//! The facets go to gmsh as a discrete surface for each shell, with one volume between them.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

use super::soup::Soup;
use crate::import::gmsh::{self, Launcher};
use crate::import::msh::Msh;
use crate::import::process::{Ended, Limits};
use crate::import::spent::Budget;
use crate::model::disjoint::Disjoint;

const INPUT: &str = "facets.msh";
const SCRIPT: &str = "fill.geo";
const MESH: &str = "filled.msh";

/// Gmsh's numbers of its volume meshers.
pub(super) const HXT: u32 = 10;
pub(super) const DELAUNAY: u32 = 1;

/// Why there are no tets.
pub(super) enum FillFault {
    /// The limit on time ran out.
    TimedOut,
    /// Gmsh does not start.
    Unusable(Vec<String>),
    /// Gmsh said so.
    Failed(Vec<String>),
}

/// What a run of gmsh needs.
pub(super) struct Filler<'a> {
    pub(super) launcher: &'a Launcher,
    pub(super) folder: &'a Path,
    pub(super) threads: usize,
    pub(super) memory_limit: Option<u64>,
}

impl Filler<'_> {
    /// Fills the facets with tets of about this size, within this time; the mesh and the version of gmsh.
    pub(super) fn fill(
        &self,
        facets: &Soup,
        size: f64,
        mesher: u32,
        (limit, budget): (Duration, &Budget),
    ) -> Result<(Msh, String), FillFault> {
        let io = |e: std::io::Error| FillFault::Failed(vec![e.to_string()]);
        let unit = unit(facets);
        let (text, shells) = discrete(facets, unit);
        std::fs::write(self.folder.join(INPUT), text).map_err(io)?;
        std::fs::write(
            self.folder.join(SCRIPT),
            script(shells, size * unit, mesher),
        )
        .map_err(io)?;
        let mesh = self.folder.join(MESH);
        if mesh.exists() {
            std::fs::remove_file(&mesh).map_err(io)?;
        }
        let threads = self.threads.max(1).to_string();
        let run = self
            .launcher
            .run(
                self.folder,
                &[SCRIPT, "-nt", &threads, "-"],
                Limits {
                    time: limit,
                    memory: self.memory_limit,
                },
            )
            .map_err(|e| FillFault::Unusable(vec![e.to_string()]))?;
        budget.charge(run.spent);
        let Ended::Exit(status) = run.ended else {
            return Err(FillFault::TimedOut);
        };
        let Some(version) = gmsh::version_in(&run.log) else {
            return Err(FillFault::Unusable(run.last_words()));
        };
        let failed = |mut lines: Vec<String>| {
            if !status.success() {
                lines.push(status.to_string());
            }
            FillFault::Failed(lines)
        };
        let bytes = match std::fs::read(&mesh) {
            Ok(bytes) if status.success() => bytes,
            _ => return Err(failed(gmsh::error_lines(&run.log))),
        };
        let mut msh = Msh::parse(&bytes).map_err(|e| failed(vec![e.to_string()]))?;
        if msh.elements.iter().all(|b| b.dimension != 3) {
            return Err(failed(gmsh::error_lines(&run.log)));
        }
        for p in &mut msh.nodes {
            *p /= unit;
        }
        Ok((msh, version))
    }
}

/// Factor to the lengths that gmsh sees: its own tolerances are absolute. A power of two, so that no bit of a coordinate is lost.
fn unit(facets: &Soup) -> f64 {
    let most = (facets.points.iter())
        .map(|p| p.abs().max_element())
        .fold(0.0, f64::max);
    let exponent = 7.0 - most.log2().ceil();
    // Where even this would leave the normal numbers no tets can be made anyway.
    if exponent.abs() < 900.0 {
        exponent.exp2()
    } else {
        1.0
    }
}

/// MSH 2.2 text, one surface a shell, and how many shells there are.
fn discrete(facets: &Soup, unit: f64) -> (String, usize) {
    let mut sets = Disjoint::new(facets.points.len());
    for &[a, b, c] in &facets.triangles {
        sets.join(a, b);
        sets.join(b, c);
    }
    let mut number = vec![0usize; facets.points.len()];
    let mut shells = 0;
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n");
    let _ = writeln!(text, "{}", facets.points.len());
    for (i, p) in facets.points.iter().map(|p| *p * unit).enumerate() {
        let _ = writeln!(text, "{} {:e} {:e} {:e}", i + 1, p.x, p.y, p.z);
    }
    let _ = writeln!(text, "$EndNodes\n$Elements\n{}", facets.triangles.len());
    for (i, &[a, b, c]) in facets.triangles.iter().enumerate() {
        let shell = &mut number[sets.find(a) as usize];
        if *shell == 0 {
            shells += 1;
            *shell = shells;
        }
        let _ = writeln!(
            text,
            "{} 2 2 0 {shell} {} {} {}",
            i + 1,
            a + 1,
            b + 1,
            c + 1
        );
    }
    text.push_str("$EndElements\n");
    (text, shells)
}

fn script(shells: usize, size: f64, mesher: u32) -> String {
    let mut loops = String::new();
    for k in 1..=shells {
        let _ = writeln!(loops, "Surface Loop({k}) = {{{k}}};");
    }
    format!(
        r#"General.Verbosity = 4;
General.AbortOnError = 2;
Merge "{INPUT}";
{loops}Volume(1) = {{1:{shells}}};
Mesh.MeshSizeMax = {size:e};
Mesh.MeshSizeMin = 0;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm3D = {mesher};
Mesh.ElementOrder = 1;
Mesh.Optimize = 0;
Mesh.OptimizeNetgen = 0;
Mesh.SaveAll = 1;
Mesh.Binary = 1;
Mesh.MshFileVersion = 4.1;
Mesh 3;
Save "{MESH}";
"#
    )
}
