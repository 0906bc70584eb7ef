//! The script that tells gmsh what to do, and the order in which other ways are tried when one fails.
//!
//! **Size of the elements.** With the mean thickness t = 2 V / A of a solid and the diagonal d of its box, the largest element has the size
//! h = factor * max(3 t, min(8 t, d / 50), d / 200): some thicknesses, more where a large part would need too many of them. 8 t at
//! ten elements a circle keep the sag of a flat facet, h² / 8 R with R = 10 h / 2 pi, below 0.7 t, so that the two sides
//! of a bent wall do not cut each other. The least size is t / 2, which holds the number of elements along thin bends.
//!
//! **Second order.** The mesh is made in first order and raised afterwards: mid-side nodes lie on the CAD surface then.

use super::gmsh::error_lines;

/// Elements around a full circle. With second-order sides ten are exact to 3e-4 of the radius.
const PER_CIRCLE: f64 = 10.0;

/// The input's plain name in the working folder, without extension.
pub(super) const INPUT: &str = "input";
/// The mesh that the script writes.
pub(super) const MESH: &str = "mesh.msh";
/// The script's own name.
pub(super) const SCRIPT: &str = "run.geo";

/// One way to ask gmsh for a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Attempt {
    pub(super) name: &'static str,
    /// Gmsh's number of the volume mesher.
    pub(super) volume_algorithm: u32,
    /// Gmsh's number of the surface mesher.
    pub(super) surface_algorithm: u32,
    /// Whether small edges and faces are taken away first.
    pub(super) heal: bool,
    /// Whether loose faces are sewn into solids first.
    pub(super) sew: bool,
    /// Factor on all sizes.
    pub(super) fineness: f64,
    /// Whether small sizes on curves reach into the faces.
    pub(super) graded: bool,
}

const HXT: Attempt = Attempt {
    name: "HXT",
    volume_algorithm: 10,
    surface_algorithm: 6,
    heal: false,
    sew: false,
    fineness: 1.0,
    graded: false,
};

/// All attempts in their order; [`Attempt::is_worth_it`] leaves out those that cannot help.
///
/// Over the 63 real parts that this was measured on HXT fills 58; where it fails, the surface mesh cuts itself (four parts), which only another surface mesh
/// mends, or HXT itself crashes.
pub(super) const ATTEMPTS: [Attempt; 6] = [
    HXT,
    Attempt {
        name: "Delaunay",
        volume_algorithm: 1,
        ..HXT
    },
    Attempt {
        name: "half the size",
        fineness: 0.5,
        graded: true,
        ..HXT
    },
    Attempt {
        name: "healed, surface Delaunay",
        surface_algorithm: 5,
        heal: true,
        graded: true,
        ..HXT
    },
    Attempt {
        name: "a quarter of the size",
        fineness: 0.25,
        graded: true,
        ..HXT
    },
    Attempt {
        name: "sewn",
        sew: true,
        graded: true,
        ..HXT
    },
];

impl Attempt {
    /// Whether the attempt can do what the last one, which wrote `log`, could not.
    pub(super) fn is_worth_it(&self, log: &str, facts: Facts) -> bool {
        let open = facts.solids == 0 || facts.is_open();
        let cuts_itself = error_lines(log)
            .iter()
            .any(|l| l.contains("PLC") || l.contains("ntersect") || l.contains("overlapping"));
        match self {
            // Sewing helps where nothing is closed, and nothing else does there.
            a if a.sew || open => a.sew && open,
            // The same surface mesh fails in the other mesher too.
            a if a.volume_algorithm != HXT.volume_algorithm => !cuts_itself,
            _ => true,
        }
    }

    /// The script, for an input with this extension and healing to this tolerance in mm.
    pub(super) fn script(&self, extension: &str, size_factor: f64, tolerance: f64) -> String {
        let factor = size_factor * self.fineness;
        let per_circle = (PER_CIRCLE / self.fineness).round();
        let mut prepare = String::new();
        if self.heal {
            prepare += &format!(
                "Geometry.Tolerance = {tolerance:e};\nGeometry.OCCFixDegenerated = 1;\n\
                 Geometry.OCCFixSmallEdges = 1;\nGeometry.OCCFixSmallFaces = 1;\n"
            );
        }
        if self.sew {
            prepare += "Geometry.OCCSewFaces = 1;\nGeometry.OCCMakeSolids = 1;\n";
        }
        format!(
            r#"General.Verbosity = 4;
General.AbortOnError = 2;
SetFactory("OpenCASCADE");
Geometry.OCCTargetUnit = "MM";
Geometry.OCCImportLabels = 0;
Geometry.OCCAutoFix = 1;
{prepare}Merge "{INPUT}.{extension}";
volumes() = Volume{{:}};
surfaces() = Surface{{:}};
nv = #volumes();
least = 1e22;
largest = 0;
open = 0;
If (nv > 0)
  For i In {{0:nv-1}}
    own() = Abs(Boundary{{ Volume{{volumes(i)}}; }});
    v = Mass Volume{{volumes(i)}};
    v = Fabs(v);
    a = 0;
    For j In {{0:#own()-1}}
      a += Mass Surface{{own(j)}};
    EndFor
    rim() = CombinedBoundary{{ Surface{{own()}}; }};
    If (#rim() > 0)
      For j In {{0:#rim()-1}}
        open += Mass Curve{{Abs(rim(j))}};
      EndFor
    EndIf
    box() = BoundingBox Volume{{volumes(i)}};
    d = Sqrt((box(3)-box(0))^2 + (box(4)-box(1))^2 + (box(5)-box(2))^2);
    t = (a > 0 && v > 0) ? 2*v/a : d/50;
    h = {factor:e}*Max(Max(3*t, d/200), (8*t < d/50) ? 8*t : d/50);
    least = (t < least) ? t : least;
    largest = Max(largest, h);
    Printf("midshell: solid %g volume %.10g area %.10g diagonal %.10g", volumes(i), v, a, d);
    If (nv > 1)
      Field[i+1] = Constant;
      Field[i+1].VolumesList = {{volumes(i)}};
      Field[i+1].VIn = h;
      Field[i+1].VOut = 1e22;
      Field[i+1].IncludeBoundary = 1;
    EndIf
  EndFor
EndIf
Printf("midshell: solids %g surfaces %g open %.10g thickness %.10g", nv, #surfaces(), open, least);
If (nv > 0)
  If (nv > 1)
    Field[nv+1] = Min;
    Field[nv+1].FieldsList = {{1:nv}};
    Background Field = nv+1;
  EndIf
  Mesh.MeshSizeMax = largest;
  Mesh.MeshSizeMin = {factor:e}*least/2;
  Mesh.MeshSizeFromCurvature = {per_circle};
  Mesh.MeshSizeFromPoints = 0;
  Mesh.MeshSizeExtendFromBoundary = {graded};
  Mesh.Algorithm = {surface};
  Mesh.Algorithm3D = {volume};
  Mesh.ElementOrder = 1;
  Mesh.Optimize = 0;
  Mesh.OptimizeNetgen = 0;
  Mesh.HighOrderOptimize = 0;
  Mesh.RecombineAll = 0;
  Mesh.SaveAll = 1;
  Mesh.SaveParametric = 0;
  Mesh.Binary = 1;
  Mesh.MshFileVersion = 4.1;
  Mesh 3;
  SetOrder 2;
  Save "{MESH}";
EndIf
"#,
            graded = u8::from(self.graded),
            surface = self.surface_algorithm,
            volume = self.volume_algorithm,
        )
    }
}

/// What the script said of the part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Facts {
    pub(super) solids: usize,
    pub(super) surfaces: usize,
    /// Length of the edges that bound one face only, mm.
    pub(super) open_mm: f64,
    /// The least mean thickness of a solid, mm.
    pub(super) thickness_mm: f64,
}

impl Facts {
    /// The facts in a log, if the script came so far.
    pub(super) fn in_log(log: &str) -> Option<Self> {
        let line = log
            .lines()
            .find_map(|l| l.split_once("midshell: solids ").map(|(_, rest)| rest))?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let [
            solids,
            "surfaces",
            surfaces,
            "open",
            open,
            "thickness",
            thickness,
        ] = words[..]
        else {
            return None;
        };
        Some(Self {
            solids: solids.parse().ok()?,
            surfaces: surfaces.parse().ok()?,
            open_mm: open.parse().ok()?,
            thickness_mm: thickness.parse().ok()?,
        })
    }

    /// Whether a boundary is open. The poles of spheres count as edges of rounding length: a tenth of a thickness is far more.
    pub(super) fn is_open(&self) -> bool {
        self.open_mm > 0.1 * self.thickness_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WELL: Facts = Facts {
        solids: 1,
        surfaces: 6,
        open_mm: 0.0,
        thickness_mm: 2.0,
    };

    fn worth(log: &str, facts: Facts) -> Vec<&'static str> {
        ATTEMPTS[1..]
            .iter()
            .filter(|a| a.is_worth_it(log, facts))
            .map(|a| a.name)
            .collect()
    }

    #[test]
    fn facts_are_read_from_the_log() {
        let log = "Info: x\nmidshell: solids 2 surfaces 12 open 1.5e-11 thickness 1.25\n";
        let facts = Facts::in_log(log).unwrap();
        assert_eq!((facts.solids, facts.surfaces), (2, 12));
        assert_eq!(facts.thickness_mm, 1.25);
        assert!(!facts.is_open());
        assert_eq!(Facts::in_log("Error: no"), None);
    }

    #[test]
    fn the_other_volume_mesher_is_not_tried_on_a_surface_that_cuts_itself() {
        assert!(worth("Error : HXT 3D mesh failed", WELL).contains(&"Delaunay"));
        assert!(!worth("PLC Error:  A segment and a facet intersect", WELL).contains(&"Delaunay"));
    }

    #[test]
    fn only_sewing_is_tried_where_nothing_is_closed() {
        let none = Facts { solids: 0, ..WELL };
        let open = Facts {
            open_mm: 30.0,
            ..WELL
        };
        assert_eq!(worth("", none), ["sewn"]);
        assert_eq!(worth("", open), ["sewn"]);
        assert!(!worth("", WELL).contains(&"sewn"));
    }
}
