//! The script that tells gmsh what to do, and the order in which other ways are tried when one fails.
//!
//! **Size of the elements.** With the mean thickness t = 2 V / A of a solid and the diagonal d of its box, the largest element has the size
//! h = factor * max(3 t, min(8 t, d / 50), d / 200): some thicknesses, more where a large part would need too many of them. 8 t at
//! sixteen elements a circle keep the sag of a flat facet, h² / 8 R with R = 16 h / 2 pi, below 0.3 t at h = 6 t, so that the two sides
//! of a bent wall do not cut each other. The least size is t / 2, which holds the number of elements along thin bends. Where d / 200 decides, bends are
//! hundreds of elements long, and most elements lie on them: there twelve a circle and 3 t / 4 do.
//!
//! **Second order.** The mesh is made in first order and raised afterwards: mid-side nodes lie on the CAD surface then.

use super::gmsh::error_lines;

/// Elements around a full circle. Second-order sides are exact to 5e-5 of the radius then; inside a facet of a sphere or cone the error
/// is larger, and with ten elements it came to a percent of a wall as thin as a tenth of the radius.
const PER_CIRCLE: f64 = 16.0;
/// The same for large thin solids. Their bends are sharp; a cylinder's second-order sides are exact to 2e-4 of the radius then.
const PER_CIRCLE_LARGE: f64 = 12.0;
/// The least size over the thickness.
const LEAST: f64 = 0.5;
/// The same for large thin solids.
const LEAST_LARGE: f64 = 0.75;

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
    /// Whether the facets stay flat, where curving them is what fails.
    pub(super) flat: bool,
    /// Whether the surface alone is meshed.
    pub(super) surface_only: bool,
    /// One size everywhere, in thicknesses, in place of the size that the module's text describes.
    pub(super) even: Option<f64>,
}

const HXT: Attempt = Attempt {
    name: "HXT",
    volume_algorithm: 10,
    surface_algorithm: 6,
    heal: false,
    sew: false,
    flat: false,
    surface_only: false,
    even: None,
};

/// All attempts in their order; [`Attempt::is_worth_it`] leaves out those that cannot help.
///
/// Where the volume mesher fails on real parts, the surface mesh cuts itself, mostly at a sliver between two curves that nearly coincide: one size everywhere
/// divides both curves alike. Of 63 real parts HXT fills 59, the coarse even size one more and the fine one another; the other
/// ways are for errors that these parts do not have. Another size comes before healing, since healing changes the part and a size does not.
pub(super) const ATTEMPTS: [Attempt; 9] = [
    HXT,
    Attempt {
        name: "flat facets",
        flat: true,
        ..HXT
    },
    Attempt {
        name: "Delaunay",
        volume_algorithm: 1,
        ..HXT
    },
    Attempt {
        name: "Frontal",
        volume_algorithm: 4,
        ..HXT
    },
    Attempt {
        name: "even size of two thicknesses",
        even: Some(2.0),
        ..HXT
    },
    Attempt {
        name: "even size of half a thickness",
        even: Some(0.5),
        ..HXT
    },
    Attempt {
        name: "healed, surface Delaunay",
        surface_algorithm: 5,
        heal: true,
        ..HXT
    },
    Attempt {
        name: "healed, surface by MeshAdapt",
        surface_algorithm: 1,
        heal: true,
        ..HXT
    },
    Attempt {
        name: "sewn",
        sew: true,
        ..HXT
    },
];

/// Surfaces for fTetWild, the last resort: the usual one, then one that is as simple as can be.
pub(super) const SURFACES: [Attempt; 2] = [
    Attempt {
        name: "fTetWild",
        surface_only: true,
        ..HXT
    },
    Attempt {
        name: "fTetWild on a plain surface",
        surface_algorithm: 5,
        surface_only: true,
        flat: true,
        even: Some(1.0),
        ..HXT
    },
];

/// More facets than this take gmsh over a minute.
const MOST_FACETS: f64 = 4e5;

impl Attempt {
    /// Whether the other one's surface mesh is the same, but for mid-side points.
    pub(super) fn has_surface_of(&self, other: &Self) -> bool {
        let surface = |a: &Self| (a.surface_algorithm, a.heal, a.sew, a.even);
        surface(self) == surface(other)
    }

    /// Whether the attempt can do what the last one, which wrote `log`, could not.
    pub(super) fn is_worth_it(&self, log: &str, ran_out_of_time: bool, facts: Facts) -> bool {
        let open = facts.solids == 0 || facts.is_open();
        let cuts_itself = error_lines(log)
            .iter()
            .any(|l| l.contains("PLC") || l.contains("ntersect") || l.contains("overlapping"));
        let few = |e| facts.even_facets(e) < MOST_FACETS;
        match self {
            // Sewing helps where nothing is closed, and nothing else does there.
            a if a.sew || open => a.sew && open,
            // The filling went well: what failed is what comes after it.
            a if a.flat => log.contains("Done meshing 3D") && !log.contains("Error"),
            // What took too long takes as long in another way, but for a coarser one.
            a if ran_out_of_time => a.even.is_some_and(|e| e > 1.0 && few(e)),
            // The same surface mesh fails in the other mesher too.
            a if a.volume_algorithm != HXT.volume_algorithm => !cuts_itself,
            a => a.even.is_none_or(few),
        }
    }

    /// The script, for an input with this extension and healing to this tolerance in mm.
    pub(super) fn script(&self, extension: &str, size_factor: f64, tolerance: f64) -> String {
        // Each first for a large thin part, then for any other.
        let (size, least, per_circle) = match self.even {
            Some(even) => (format!("{even:e}*t"), [even; 2], [0.0; 2]),
            None => (
                format!("{size_factor:e}*Max(Max(3*t, d/200), (8*t < d/50) ? 8*t : d/50)"),
                [LEAST_LARGE, LEAST].map(|l| l * size_factor),
                [PER_CIRCLE_LARGE, PER_CIRCLE],
            ),
        };
        let either = |[large, other]: [f64; 2]| format!("(large ? {large:e} : {other:e})");
        let (least, per_circle) = (either(least), either(per_circle));
        // A face that cannot be meshed need not end the attempt: what heals, or bridges the gap, comes after it.
        let abort = if self.heal || self.surface_only { 0 } else { 2 };
        let dimension = if self.surface_only { 2 } else { 3 };
        let order = if self.flat { "" } else { "SetOrder 2;" };
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
General.AbortOnError = {abort};
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
large = 1;
area = 0;
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
    area += a;
    rim() = CombinedBoundary{{ Surface{{own()}}; }};
    If (#rim() > 0)
      For j In {{0:#rim()-1}}
        open += Mass Curve{{Abs(rim(j))}};
      EndFor
    EndIf
    box() = BoundingBox Volume{{volumes(i)}};
    d = Sqrt((box(3)-box(0))^2 + (box(4)-box(1))^2 + (box(5)-box(2))^2);
    t = (a > 0 && v > 0) ? 2*v/a : d/50;
    h = {size};
    large = (d/200 > 3*t) ? large : 0;
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
ElseIf (#surfaces() > 0)
  rim() = CombinedBoundary{{ Surface{{surfaces()}}; }};
  If (#rim() > 0)
    For j In {{0:#rim()-1}}
      open += Mass Curve{{Abs(rim(j))}};
    EndFor
  EndIf
EndIf
Printf("midshell: solids %g surfaces %g open %.10g thickness %.10g area %.10g", nv, #surfaces(), open, least, area);
If (nv > 0)
  If (nv > 1)
    Field[nv+1] = Min;
    Field[nv+1].FieldsList = {{1:nv}};
    Background Field = nv+1;
  EndIf
  Mesh.MeshSizeMax = largest;
  Mesh.MeshSizeMin = {least}*least;
  Mesh.MeshSizeFromCurvature = {per_circle};
  Mesh.MeshSizeFromPoints = 0;
  Mesh.MeshSizeExtendFromBoundary = 0;
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
  Mesh {dimension};
  {order}
  Save "{MESH}";
EndIf
"#,
            surface = self.surface_algorithm,
            volume = self.volume_algorithm,
        )
    }
}

/// What the script said of one solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SolidFacts {
    pub(super) tag: i32,
    /// Exact, mm³.
    pub(super) volume: f64,
    /// Exact, mm².
    pub(super) area: f64,
    /// Of its box, mm.
    pub(super) diagonal: f64,
}

impl SolidFacts {
    /// The facts in a log, one a solid.
    pub(super) fn in_log(log: &str) -> Vec<Self> {
        let lines = log
            .lines()
            .filter_map(|l| Some(l.split_once("midshell: solid ")?.1));
        let read = |line: &str| {
            let words: Vec<&str> = line.split_whitespace().collect();
            let [tag, "volume", volume, "area", area, "diagonal", diagonal] = words[..] else {
                return None;
            };
            Some(Self {
                tag: tag.parse::<f64>().ok()? as i32,
                volume: volume.parse().ok()?,
                area: area.parse().ok()?,
                diagonal: diagonal.parse().ok()?,
            })
        };
        lines.filter_map(read).collect()
    }

    /// Mean thickness, mm.
    pub(super) fn thickness(&self) -> f64 {
        2.0 * self.volume / self.area
    }

    /// Largest element size, mm: as the module's text describes it.
    pub(super) fn size(&self, factor: f64) -> f64 {
        let (t, d) = (self.thickness(), self.diagonal);
        factor * (3.0 * t).max(d / 200.0).max((8.0 * t).min(d / 50.0))
    }
}

/// What the script said of the part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Facts {
    pub(super) solids: usize,
    pub(super) surfaces: usize,
    /// Length of the edges that bound one face only, of the solids or, where there is none, of all surfaces, mm.
    pub(super) open_mm: f64,
    /// The least mean thickness of a solid, mm.
    pub(super) thickness_mm: f64,
    /// Area of all faces of solids, mm².
    pub(super) area_mm2: f64,
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
            "area",
            area,
        ] = words[..]
        else {
            return None;
        };
        Some(Self {
            solids: solids.parse().ok()?,
            surfaces: surfaces.parse().ok()?,
            open_mm: open.parse().ok()?,
            thickness_mm: thickness.parse().ok()?,
            area_mm2: area.parse().ok()?,
        })
    }

    /// How many facets an even size of so many thicknesses makes: equilateral triangles over the whole area.
    fn even_facets(&self, even: f64) -> f64 {
        let size = even * self.thickness_mm;
        self.area_mm2 / (size * size * 3f64.sqrt() / 4.0)
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
        area_mm2: 4000.0,
    };

    fn worth(log: &str, facts: Facts) -> Vec<&'static str> {
        ATTEMPTS[1..]
            .iter()
            .filter(|a| a.is_worth_it(log, false, facts))
            .map(|a| a.name)
            .collect()
    }

    #[test]
    fn facts_are_read_from_the_log() {
        let log = "Info: x\nmidshell: solids 2 surfaces 12 open 1.5e-11 thickness 1.25 area 400\n";
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
    fn an_even_size_is_not_tried_where_it_makes_too_many_facets() {
        let large = Facts {
            area_mm2: 1e6,
            ..WELL
        };
        let names = worth("PLC Error", large);
        assert!(names.contains(&"even size of two thicknesses"));
        assert!(!names.contains(&"even size of half a thickness"));
        assert!(worth("PLC Error", WELL).contains(&"even size of half a thickness"));
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

    #[test]
    fn what_took_too_long_is_only_tried_coarser() {
        let names: Vec<&str> = ATTEMPTS[1..]
            .iter()
            .filter(|a| a.is_worth_it("", true, WELL))
            .map(|a| a.name)
            .collect();
        assert_eq!(names, ["even size of two thicknesses"]);
    }

    #[test]
    fn flat_facets_are_tried_only_where_the_filling_went_well() {
        assert!(worth("Info : Done meshing 3D (Wall 1s)", WELL).contains(&"flat facets"));
        assert!(!worth("Error : HXT 3D mesh failed", WELL).contains(&"flat facets"));
    }

    #[test]
    fn the_facts_of_a_solid_are_read_and_give_its_size() {
        let log = "x\nmidshell: solid 3 volume 12000 area 12640 diagonal 116.6\n";
        let [facts] = SolidFacts::in_log(log)[..] else {
            panic!("one solid");
        };
        assert_eq!(facts.tag, 3);
        assert!((facts.thickness() - 1.898_734).abs() < 1e-6);
        // 3 t is more than an eightieth of the diagonal and more than a two-hundredth.
        assert!((facts.size(2.0) - 6.0 * facts.thickness()).abs() < 1e-12);
    }
}
