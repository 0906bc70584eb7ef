//! A reader of binary MSH 4.1, the mesh format of gmsh.
//!
//! Reads `$MeshFormat`, `$PhysicalNames`, `$Entities`, `$Nodes` and `$Elements` in either byte order; other sections are skipped.
//!
//! Guarantees: every count is held against the bytes that are left before anything is allocated for it, so that no file, however
//! broken, makes the reader panic or ask for more than a small multiple of the file's size; every node that an element names
//! exists. Limits: ASCII files, other versions and elements other than points, lines, triangles and tets (of first or second
//! order) are refused.
//!
//! Reference: Gmsh reference manual, "MSH file format", version 4.1.

use std::collections::HashMap;

use glam::DVec3;

/// What is wrong with the bytes of a mesh file, and at which byte.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("MSH file, byte {offset}: {kind}")]
pub struct MshError {
    /// Where in the file, in bytes.
    pub offset: usize,
    /// What is wrong there.
    pub kind: MshErrorKind,
}

/// The kinds of [`MshError`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MshErrorKind {
    /// The file ends inside something.
    #[error("the file ends inside {0}")]
    Truncated(&'static str),
    /// Not a binary MSH 4.1 file with eight-byte sizes.
    #[error("not a binary MSH 4.1 file: {0}")]
    Format(&'static str),
    /// A count that the file's length cannot hold, or a negative one.
    #[error("{count} entries of {what} cannot be in what is left of the file")]
    Count {
        /// What is counted.
        what: &'static str,
        /// The count as read.
        count: u64,
    },
    /// A number with no meaning there.
    #[error("{value} is no {what}")]
    Value {
        /// What was expected.
        what: &'static str,
        /// The number as read.
        value: i64,
    },
    /// A section's end mark is missing.
    #[error("{0} is expected")]
    Mark(&'static str),
    /// A node's number is used twice.
    #[error("node {0} is defined twice")]
    DoubleNode(u64),
    /// An element names a node that does not exist.
    #[error("node {0} is used but not defined")]
    MissingNode(u64),
    /// A section is missing.
    #[error("the section {0} is missing")]
    MissingSection(&'static str),
}

/// A point, curve, surface or volume of the model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MshEntity {
    /// Its number, unique among entities of its dimension.
    pub tag: i32,
    /// The numbers of the physical groups that it belongs to.
    pub physical: Vec<i32>,
    /// The signed numbers of the entities of one dimension less that bound it.
    pub boundary: Vec<i32>,
}

/// The shape of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementKind {
    /// One node.
    Point,
    /// Two nodes.
    Line2,
    /// Two ends, then the middle.
    Line3,
    /// Three corners.
    Triangle3,
    /// Three corners, then the middles of sides (0,1), (1,2), (2,0).
    Triangle6,
    /// Four corners.
    Tet4,
    /// Four corners, then six middles.
    Tet10,
}

impl ElementKind {
    fn from_number(number: i32) -> Option<Self> {
        Some(match number {
            15 => Self::Point,
            1 => Self::Line2,
            8 => Self::Line3,
            2 => Self::Triangle3,
            9 => Self::Triangle6,
            4 => Self::Tet4,
            11 => Self::Tet10,
            _ => return None,
        })
    }

    /// How many nodes an element has.
    pub fn node_count(self) -> usize {
        match self {
            Self::Point => 1,
            Self::Line2 => 2,
            Self::Line3 | Self::Triangle3 => 3,
            Self::Triangle6 => 6,
            Self::Tet4 => 4,
            Self::Tet10 => 10,
        }
    }
}

/// Elements of one kind on one entity.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementBlock {
    /// Dimension of the entity, 0 to 3.
    pub dimension: usize,
    /// Number of the entity.
    pub entity: i32,
    /// The shape of all its elements.
    pub kind: ElementKind,
    /// Positions in [`Msh::nodes`], [`ElementKind::node_count`] an element.
    pub nodes: Vec<u32>,
}

/// A mesh file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Msh {
    /// Names of physical groups by dimension and number.
    pub physical_names: Vec<(i32, i32, String)>,
    /// Points, curves, surfaces, volumes.
    pub entities: [Vec<MshEntity>; 4],
    /// #N positions, in the order of the file.
    pub nodes: Vec<DVec3>,
    /// Elements in the order of the file.
    pub elements: Vec<ElementBlock>,
}

impl Msh {
    /// Reads a whole file.
    pub fn parse(bytes: &[u8]) -> Result<Self, MshError> {
        let mut reader = Reader {
            bytes,
            at: 0,
            swapped: false,
        };
        reader.format()?;
        let mut msh = Self::default();
        let mut numbering = None;
        let mut seen_elements = false;
        while reader.at < bytes.len() {
            let start = reader.at;
            match reader.line("a section's name")? {
                b"$PhysicalNames" => {
                    msh.physical_names = reader.physical_names()?;
                    reader.end("$EndPhysicalNames")?;
                }
                b"$Entities" => {
                    msh.entities = reader.entities()?;
                    reader.end("$EndEntities")?;
                }
                b"$Nodes" => {
                    let (nodes, tags) = reader.nodes()?;
                    msh.nodes = nodes;
                    numbering = Some(tags);
                    reader.end("$EndNodes")?;
                }
                b"$Elements" => {
                    let Some(numbering) = &numbering else {
                        return Err(reader.error(start, MshErrorKind::MissingSection("$Nodes")));
                    };
                    msh.elements = reader.elements(numbering)?;
                    seen_elements = true;
                    reader.end("$EndElements")?;
                }
                [] => {}
                [b'$', name @ ..] => reader.skip_section(name)?,
                _ => return Err(reader.error(start, MshErrorKind::Mark("a section"))),
            }
        }
        if !seen_elements {
            return Err(reader.error(bytes.len(), MshErrorKind::MissingSection("$Elements")));
        }
        Ok(msh)
    }
}

/// From the file's node numbers to positions in the list of nodes.
enum Numbering {
    /// Numbers start here and leave few gaps: a table, `u32::MAX` for a gap.
    Dense { first: u64, table: Vec<u32> },
    /// Any numbers.
    Sparse(HashMap<u64, u32>),
}

impl Numbering {
    /// A table of this many times the nodes is still cheaper than a map.
    const GAPS: u64 = 8;

    fn new(tags: &[u64]) -> Result<Self, u64> {
        let first = tags.iter().copied().min().unwrap_or(0);
        let last = tags.iter().copied().max().unwrap_or(0);
        if last - first < Self::GAPS * tags.len() as u64 {
            let mut table = vec![u32::MAX; (last - first) as usize + 1];
            for (at, &tag) in (0u32..).zip(tags) {
                let slot = &mut table[(tag - first) as usize];
                if *slot != u32::MAX {
                    return Err(tag);
                }
                *slot = at;
            }
            return Ok(Self::Dense { first, table });
        }
        let mut map = HashMap::with_capacity(tags.len());
        for (at, &tag) in (0u32..).zip(tags) {
            if map.insert(tag, at).is_some() {
                return Err(tag);
            }
        }
        Ok(Self::Sparse(map))
    }

    fn get(&self, tag: u64) -> Option<u32> {
        match self {
            Self::Dense { first, table } => table
                .get(usize::try_from(tag.checked_sub(*first)?).ok()?)
                .copied()
                .filter(|&at| at != u32::MAX),
            Self::Sparse(map) => map.get(&tag).copied(),
        }
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    swapped: bool,
}

impl<'a> Reader<'a> {
    fn error(&self, offset: usize, kind: MshErrorKind) -> MshError {
        MshError { offset, kind }
    }

    fn line(&mut self, what: &'static str) -> Result<&'a [u8], MshError> {
        let rest = &self.bytes[self.at..];
        let Some(end) = rest.iter().position(|&b| b == b'\n') else {
            return Err(self.error(self.bytes.len(), MshErrorKind::Truncated(what)));
        };
        self.at += end + 1;
        let line = &rest[..end];
        Ok(line.strip_suffix(b"\r").unwrap_or(line))
    }

    fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], MshError> {
        let Some(chunk) = self.bytes[self.at..].first_chunk::<N>() else {
            return Err(self.error(self.bytes.len(), MshErrorKind::Truncated(what)));
        };
        self.at += N;
        let mut chunk = *chunk;
        if self.swapped {
            chunk.reverse();
        }
        Ok(chunk)
    }

    fn i32(&mut self, what: &'static str) -> Result<i32, MshError> {
        self.array(what).map(i32::from_le_bytes)
    }

    fn u64(&mut self, what: &'static str) -> Result<u64, MshError> {
        self.array(what).map(u64::from_le_bytes)
    }

    fn f64(&mut self, what: &'static str) -> Result<f64, MshError> {
        self.array(what).map(f64::from_le_bytes)
    }

    /// A count of things of at least `size` bytes each: never more than the rest of the file can hold.
    fn count(&mut self, what: &'static str, size: usize) -> Result<usize, MshError> {
        let start = self.at;
        let count = self.u64(what)?;
        let room = (self.bytes.len() - self.at) / size;
        match usize::try_from(count) {
            Ok(n) if n <= room => Ok(n),
            _ => Err(self.error(start, MshErrorKind::Count { what, count })),
        }
    }

    fn dimension(&mut self, what: &'static str) -> Result<usize, MshError> {
        let start = self.at;
        let value = self.i32(what)?;
        match usize::try_from(value) {
            Ok(n) if n <= 3 => Ok(n),
            _ => Err(self.error(
                start,
                MshErrorKind::Value {
                    what: "dimension",
                    value: value.into(),
                },
            )),
        }
    }

    fn format(&mut self) -> Result<(), MshError> {
        if self.line("$MeshFormat")? != b"$MeshFormat" {
            return Err(self.error(
                0,
                MshErrorKind::Format("it does not begin with $MeshFormat"),
            ));
        }
        let start = self.at;
        let line = String::from_utf8_lossy(self.line("the version")?).into_owned();
        let mut words = line.split_ascii_whitespace();
        if words.next() != Some("4.1") {
            return Err(self.error(start, MshErrorKind::Format("another version")));
        }
        if words.next() != Some("1") {
            return Err(self.error(start, MshErrorKind::Format("ASCII")));
        }
        if words.next() != Some("8") {
            return Err(self.error(start, MshErrorKind::Format("another size of numbers")));
        }
        let start = self.at;
        match self.array::<4>("the byte order")? {
            [1, 0, 0, 0] => {}
            [0, 0, 0, 1] => self.swapped = true,
            _ => return Err(self.error(start, MshErrorKind::Format("unknown byte order"))),
        }
        self.end("$EndMeshFormat")
    }

    /// The end mark of a section, after the line break that follows binary data.
    fn end(&mut self, mark: &'static str) -> Result<(), MshError> {
        let start = self.at;
        let mut line = self.line(mark)?;
        if line.is_empty() {
            line = self.line(mark)?;
        }
        if line == mark.as_bytes() {
            Ok(())
        } else {
            Err(self.error(start, MshErrorKind::Mark(mark)))
        }
    }

    fn skip_section(&mut self, name: &[u8]) -> Result<(), MshError> {
        let mark = [b"$End", name].concat();
        let found = self.bytes[self.at..]
            .windows(mark.len())
            .position(|w| w == mark);
        match found {
            Some(end) => {
                self.at += end;
                self.line("a section's end").map(|_| ())
            }
            None => Err(self.error(self.bytes.len(), MshErrorKind::Truncated("a section"))),
        }
    }

    fn physical_names(&mut self) -> Result<Vec<(i32, i32, String)>, MshError> {
        let start = self.at;
        let bad = |value| MshErrorKind::Value {
            what: "physical name",
            value,
        };
        let line = String::from_utf8_lossy(self.line("$PhysicalNames")?).into_owned();
        let count: usize = line
            .trim()
            .parse()
            .map_err(|_| self.error(start, bad(-1)))?;
        let mut names = Vec::new();
        for _ in 0..count {
            let start = self.at;
            let line = String::from_utf8_lossy(self.line("$PhysicalNames")?).into_owned();
            let mut parts = line.splitn(3, ' ');
            let mut number = || parts.next().and_then(|w| w.parse::<i32>().ok());
            let (Some(dimension), Some(tag)) = (number(), number()) else {
                return Err(self.error(start, bad(names.len() as i64)));
            };
            let name = parts.next().unwrap_or_default().trim().trim_matches('"');
            names.push((dimension, tag, name.to_owned()));
        }
        Ok(names)
    }

    fn tags(&mut self, what: &'static str) -> Result<Vec<i32>, MshError> {
        let count = self.count(what, 4)?;
        (0..count).map(|_| self.i32(what)).collect()
    }

    fn entities(&mut self) -> Result<[Vec<MshEntity>; 4], MshError> {
        const WHAT: &str = "$Entities";
        let mut counts = [0; 4];
        for count in &mut counts {
            // The shortest entity is a point: a number, three coordinates, a count.
            *count = self.count(WHAT, 36)?;
        }
        let mut entities: [Vec<MshEntity>; 4] = Default::default();
        for (dimension, list) in entities.iter_mut().enumerate() {
            for _ in 0..counts[dimension] {
                let tag = self.i32(WHAT)?;
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    self.f64(WHAT)?;
                }
                let physical = self.tags(WHAT)?;
                let boundary = if dimension == 0 {
                    Vec::new()
                } else {
                    self.tags(WHAT)?
                };
                list.push(MshEntity {
                    tag,
                    physical,
                    boundary,
                });
            }
        }
        Ok(entities)
    }

    fn nodes(&mut self) -> Result<(Vec<DVec3>, Numbering), MshError> {
        const WHAT: &str = "$Nodes";
        let start = self.at;
        let blocks = self.count(WHAT, 20)?;
        let total = self.count(WHAT, 32)?;
        let too_many = || MshErrorKind::Count {
            what: WHAT,
            count: total as u64,
        };
        if total >= u32::MAX as usize {
            return Err(self.error(start, too_many()));
        }
        self.u64(WHAT)?;
        self.u64(WHAT)?;
        let mut nodes = Vec::with_capacity(total);
        let mut tags = Vec::with_capacity(total);
        for _ in 0..blocks {
            let dimension = self.dimension(WHAT)?;
            self.i32(WHAT)?;
            let parametric = self.i32(WHAT)? != 0;
            let extra = if parametric { dimension } else { 0 };
            let count = self.count(WHAT, 32 + 8 * extra)?;
            if tags.len() + count > total {
                return Err(self.error(self.at, too_many()));
            }
            for _ in 0..count {
                tags.push(self.u64(WHAT)?);
            }
            for _ in 0..count {
                let (x, y, z) = (self.f64(WHAT)?, self.f64(WHAT)?, self.f64(WHAT)?);
                nodes.push(DVec3::new(x, y, z));
                for _ in 0..extra {
                    self.f64(WHAT)?;
                }
            }
        }
        if nodes.len() != total {
            return Err(self.error(self.at, too_many()));
        }
        match Numbering::new(&tags) {
            Ok(numbering) => Ok((nodes, numbering)),
            Err(tag) => Err(self.error(start, MshErrorKind::DoubleNode(tag))),
        }
    }

    fn elements(&mut self, numbering: &Numbering) -> Result<Vec<ElementBlock>, MshError> {
        const WHAT: &str = "$Elements";
        let count = self.count(WHAT, 20)?;
        for _ in 0..3 {
            self.u64(WHAT)?;
        }
        let mut blocks = Vec::with_capacity(count);
        for _ in 0..count {
            let dimension = self.dimension(WHAT)?;
            let entity = self.i32(WHAT)?;
            let start = self.at;
            let number = self.i32(WHAT)?;
            let kind = ElementKind::from_number(number).ok_or_else(|| {
                self.error(
                    start,
                    MshErrorKind::Value {
                        what: "element type that is read here",
                        value: number.into(),
                    },
                )
            })?;
            let per = kind.node_count();
            let count = self.count(WHAT, 8 * (1 + per))?;
            let mut nodes = Vec::with_capacity(count * per);
            for _ in 0..count {
                self.u64(WHAT)?;
                for _ in 0..per {
                    let start = self.at;
                    let tag = self.u64(WHAT)?;
                    let node = numbering
                        .get(tag)
                        .ok_or_else(|| self.error(start, MshErrorKind::MissingNode(tag)))?;
                    nodes.push(node);
                }
            }
            blocks.push(ElementBlock {
                dimension,
                entity,
                kind,
                nodes,
            });
        }
        Ok(blocks)
    }
}

#[cfg(test)]
#[path = "msh_tests.rs"]
mod tests;
