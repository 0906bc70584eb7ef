//! Reasons to doubt a result: what is wrong, what that means for a shell model, what to do, and where to look.

use super::ids::ElementId;
use glam::DVec3;
use serde::Serialize;

/// A reason to doubt a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DoubtRule {
    /// Euler characteristics differ.
    Euler,
    /// The number of edge-connected pieces is not that of the solids.
    Pieces,
    /// Too much of the mesh is off the middle.
    RError,
    /// Wall area without mesh.
    Cover,
    /// Mesh outside the solid.
    Outside,
    /// Thickness values that do not fit the solid.
    Thickness,
    /// Free edges that are on no rim.
    FreeEdges,
    /// Elements that are folded over or inside out.
    Flipped,
    /// Neighbours in one sheet with opposite normals.
    Orientation,
    /// Coordinates or thicknesses that are not finite, or elements that name missing nodes.
    NotFinite,
    /// Nodes without element.
    Orphans,
    /// No sample could be measured.
    Unmeasured,
    /// The mesh encloses more or fewer voids than the solid.
    Voids,
    /// Material missing or there twice.
    Mass,
}

impl DoubtRule {
    /// All rules, in the order of reports.
    pub const ALL: [DoubtRule; 14] = [
        DoubtRule::Euler,
        DoubtRule::Pieces,
        DoubtRule::RError,
        DoubtRule::Cover,
        DoubtRule::Outside,
        DoubtRule::Thickness,
        DoubtRule::FreeEdges,
        DoubtRule::Flipped,
        DoubtRule::Orientation,
        DoubtRule::NotFinite,
        DoubtRule::Orphans,
        DoubtRule::Unmeasured,
        DoubtRule::Voids,
        DoubtRule::Mass,
    ];

    /// Its bit in the cell field `doubt`: 1 for the first of [`DoubtRule::ALL`], 2, 4 and so on.
    pub fn bit(self) -> u32 {
        1 << self as u32
    }

    /// Its code in reports.
    pub fn code(self) -> &'static str {
        self.text().0
    }

    /// What it means for a shell model.
    pub fn meaning(self) -> &'static str {
        self.text().1
    }

    /// What to do about it.
    pub fn remedy(self) -> &'static str {
        self.text().2
    }

    fn text(self) -> (&'static str, &'static str, &'static str) {
        match self {
            DoubtRule::Euler => (
                "euler",
                "the mesh has a gap, slit, hole or void that the solid has not, or lacks one that it has",
                "look along the free edges; try another size, or split the part where walls meet in a lump",
            ),
            DoubtRule::Pieces => (
                "pieces",
                "the mesh does not hang together as the solid does: a solver would see parts fly apart",
                "look for free edges inside the part; join the pieces by hand, or try another size",
            ),
            DoubtRule::RError => (
                "r-error",
                "about one twentieth of the mesh or more is not midway between the two sides of its wall: bending stiffness is off there",
                "use smaller elements on curved walls; check walls whose two sides are not alike",
            ),
            DoubtRule::Cover => (
                "cover",
                "a wall of the solid has no mesh on its middle: its stiffness and mass are missing",
                "look which wall is bare; very short or tapering walls may need a smaller size",
            ),
            DoubtRule::Outside => (
                "outside",
                "part of the mesh lies outside the material",
                "use smaller elements on curved walls; check rims and junctions",
            ),
            DoubtRule::Thickness => (
                "thickness",
                "the thickness in the mesh is not what the solid measures: stiffness goes with its cube",
                "check walls of varying thickness, or set the thickness of the sheets by hand",
            ),
            DoubtRule::FreeEdges => (
                "free-edges",
                "free edges run inside the part, where no rim is: sheets that should be joined are not, or end too early",
                "look along the free edges; join them by hand, or try another size",
            ),
            DoubtRule::Flipped => (
                "flipped",
                "elements are folded over, inside out or without area: a solver stops on them",
                "try another size; look at the listed worst elements",
            ),
            DoubtRule::Orientation => (
                "orientation",
                "neighbours in one sheet have opposite normals: pressure loads and offsets change sign there",
                "let the pre-processor align the normals of the sheet, unless it is one-sided",
            ),
            DoubtRule::NotFinite => (
                "not-finite",
                "a coordinate or a thickness is not a finite positive number, or an element names a node that does not exist",
                "report the part: no input should lead to this",
            ),
            DoubtRule::Orphans => (
                "orphans",
                "nodes belong to no element: some solvers stop on them",
                "report the part: no input should lead to this",
            ),
            DoubtRule::Unmeasured => (
                "unmeasured",
                "no point of the mesh lies between two sides of the solid, so that nothing could be measured",
                "check that the part is thin-walled and that mesh and solid belong together",
            ),
            DoubtRule::Voids => (
                "voids",
                "the mesh encloses a void that the solid has not, or leaves one open that it has, and something else makes up for it in the Euler characteristic",
                "look at the closed sheets and along the free edges; try another size",
            ),
            DoubtRule::Mass => (
                "mass",
                "much of the solid's material is missing in the mesh or there twice, also when what walls share at a junction counts once",
                "look where the thickness is wrong; blocks that no shell stands for are better left solid",
            ),
        }
    }
}

/// Where a doubt arises: elements, edges or samples that hang together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Place {
    /// The worst point of them, mm.
    pub at: DVec3,
    /// How far they reach from there, mm.
    pub reach: f64,
    /// The worst value there, in the unit of the doubt; 1 where the rule only counts.
    pub worst: f64,
    /// How many there are.
    pub count: usize,
    /// Tags of the faces of the solid that most of them lie between, at most [`Place::MOST`], in order.
    pub faces: Vec<i32>,
    /// The elements there, worst first, at most [`Place::MOST`]; none where a wall has no mesh at all. Counted from 0, as the cells of a VTU file;
    /// solver decks count from 1.
    pub elements: Vec<ElementId>,
}

impl Place {
    /// Places a doubt, faces and elements a place that are told.
    pub const MOST: usize = 10;
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.at.to_array();
        write!(f, "({x:.4}, {y:.4}, {z:.4})")?;
        let mut list = |what: &str, tags: Vec<String>| match tags.len() {
            0 => Ok(()),
            1 => write!(f, ", {what} {}", tags[0]),
            _ => write!(f, ", {what}s {}", tags.join(" ")),
        };
        list("face", self.faces.iter().map(ToString::to_string).collect())?;
        let few = self.elements.iter().take(3);
        list("element", few.map(|e| e.0.to_string()).collect())
    }
}

/// One doubt: a value beyond its limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// Which rule.
    pub rule: DoubtRule,
    /// What was measured.
    pub value: f64,
    /// What would have been right.
    pub limit: f64,
    /// Where, the largest first, at most [`Place::MOST`].
    pub places: Vec<Place>,
    /// How many places there are.
    pub place_count: usize,
}

impl std::fmt::Display for Doubt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}: {} ({:.4}, limit {:.4})",
            self.rule.code(),
            self.rule.meaning(),
            self.value,
            self.limit
        )?;
        match self.places.first() {
            Some(first) => write!(f, "; first at {first}"),
            None => Ok(()),
        }
    }
}

impl Serialize for Doubt {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Full<'a> {
            code: &'static str,
            bit: u32,
            value: f64,
            limit: f64,
            meaning: &'static str,
            remedy: &'static str,
            place_count: usize,
            places: &'a [Place],
        }
        Full {
            code: self.rule.code(),
            bit: self.rule.bit(),
            value: self.value,
            limit: self.limit,
            meaning: self.rule.meaning(),
            remedy: self.rule.remedy(),
            place_count: self.place_count,
            places: &self.places,
        }
        .serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::report::Verdict;

    #[test]
    fn every_rule_has_a_code_and_a_bit_of_its_own_and_both_sentences() {
        let mut codes: Vec<&str> = DoubtRule::ALL.iter().map(|r| r.code()).collect();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(codes.len(), DoubtRule::ALL.len());
        for (i, rule) in DoubtRule::ALL.into_iter().enumerate() {
            assert_eq!(rule.bit(), 1 << i);
            assert!(rule.meaning().len() > 20 && rule.remedy().len() > 20);
            assert_eq!(
                serde_json::to_value(rule).unwrap(),
                serde_json::json!(rule.code()),
            );
        }
    }

    #[test]
    fn a_doubt_tells_its_words_and_its_places() {
        let doubt = Doubt {
            rule: DoubtRule::Cover,
            value: 0.5,
            limit: 0.955,
            places: vec![Place {
                at: DVec3::new(1.0, 2.5, 3.0),
                reach: 4.0,
                worst: 0.5,
                count: 12,
                faces: vec![3, 8],
                elements: vec![],
            }],
            place_count: 1,
        };
        assert!(
            doubt
                .to_string()
                .ends_with("limit 0.9550); first at (1.0000, 2.5000, 3.0000), faces 3 8")
        );
        let json = serde_json::to_value(Verdict::Doubted(vec![doubt])).unwrap();
        let doubt = &json["doubted"][0];
        assert_eq!(
            (&doubt["code"], &doubt["bit"]),
            (&"cover".into(), &8.into())
        );
        assert!(doubt["remedy"].is_string());
        assert_eq!(doubt["places"][0]["faces"], serde_json::json!([3, 8]));
    }
}
