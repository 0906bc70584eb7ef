//! Abaqus and CalculiX input decks (`.inp`): nodes, elements, sets and the thickness of shell sections.
//!
//! Thickness comes from `*SHELL SECTION` (layers of a composite are added up), `NODAL THICKNESS` with `*NODAL THICKNESS`, `SHELL THICKNESS=` with a `*DISTRIBUTION`.
//! Limits: included files are refused, not opened; decks of several parts are refused, since their numbers clash; of an instance its place in the assembly is not taken.
//!
//! References: Abaqus keyword reference; CalculiX CrunchiX user's manual.

use super::error::{ReadError, ReadErrorKind, expected};
use super::inp_elements::{Shape, shape};
use super::raw::{Numbers, Raw};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap, HashSet};

/// A shell section: the set that it is for and where its thickness comes from.
struct Section {
    set: String,
    thickness: f64,
    is_nodal: bool,
    distribution: Option<String>,
}

/// A keyword line: its name and parameters in capitals, blanks taken out of the names.
#[derive(Default)]
struct Keyword {
    name: String,
    parameters: BTreeMap<String, String>,
}

impl Keyword {
    fn parse(line: &str) -> Self {
        let mut parts = line.trim_start_matches('*').split(',');
        let plain = |text: &str| {
            text.split_whitespace()
                .collect::<Vec<_>>()
                .join(" ")
                .to_ascii_uppercase()
        };
        let name = plain(parts.next().unwrap_or_default());
        let parameters = parts.map(|part| {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            (plain(key), plain(value.trim().trim_matches('"')))
        });
        Self {
            name,
            parameters: parameters.collect(),
        }
    }

    fn get(&self, key: &str) -> Option<&String> {
        self.parameters.get(key)
    }

    fn has(&self, key: &str) -> bool {
        self.parameters.contains_key(key)
    }
}

#[derive(Default)]
struct Deck {
    raw: Raw,
    numbers: Numbers,
    element_numbers: HashSet<u64>,
    element_sets: HashMap<String, Vec<u64>>,
    node_sets: HashMap<String, Vec<u64>>,
    sections: Vec<Section>,
    nodal: HashMap<u64, f64>,
    distributions: HashMap<String, (f64, HashMap<u64, f64>)>,
    parts: usize,
    in_assembly: bool,
    in_instance: bool,
    /// The numbers of an element that goes on in the next line.
    pending: Vec<u64>,
}

/// Reads a whole file.
pub(super) fn parse(bytes: &[u8]) -> Result<Raw, ReadError> {
    let mut deck = Deck::default();
    let mut keyword = Keyword::default();
    let mut seen_keyword = false;
    let mut data_line = 0;
    let mut lines = (1..).zip(bytes.split(|&b| b == b'\n')).peekable();
    while let Some((number, line)) = lines.next() {
        let line = line.trim_ascii();
        if line.is_empty() || line.starts_with(b"**") {
            continue;
        }
        let text = String::from_utf8_lossy(line);
        if !line.starts_with(b"*") {
            if !seen_keyword {
                return Err(expected("a keyword that begins with *", line).line(number));
            }
            data_line += 1;
            deck.data(&keyword, &text, data_line)
                .map_err(|k| k.line(number))?;
            continue;
        }
        deck.finish_element(&keyword).map_err(|k| k.line(number))?;
        let mut text = text.into_owned();
        while text.ends_with(',') {
            let Some((_, next)) = lines.next() else { break };
            text.push_str(&String::from_utf8_lossy(next.trim_ascii()));
        }
        keyword = Keyword::parse(&text);
        seen_keyword = true;
        data_line = 0;
        deck.keyword(&keyword).map_err(|k| k.line(number))?;
    }
    deck.finish_element(&keyword)
        .map_err(ReadErrorKind::anywhere)?;
    deck.thicken();
    Ok(deck.raw)
}

impl Deck {
    fn keyword(&mut self, keyword: &Keyword) -> Result<(), ReadErrorKind> {
        let refuse = |what: String, remedy| {
            Err(ReadErrorKind::Format {
                what: what.into(),
                remedy,
            })
        };
        match keyword.name.as_str() {
            "INCLUDE" => {
                return refuse(
                    format!(
                        "it includes {}",
                        keyword.get("INPUT").map_or("a file", String::as_str)
                    ),
                    "put the contents of the included file in the place of the *INCLUDE line",
                );
            }
            "NODE" | "ELEMENT" if keyword.has("INPUT") => {
                return refuse(
                    format!("its *{} stand in another file", keyword.name),
                    "put the contents of that file below the keyword",
                );
            }
            "NODE" if !matches!(keyword.get("SYSTEM").map(String::as_str), None | Some("R")) => {
                return refuse(
                    "its nodes are given in cylindrical or spherical coordinates".into(),
                    "write the deck with rectangular coordinates",
                );
            }
            "SYSTEM" | "NGEN" | "NFILL" | "NCOPY" | "ELGEN" | "ELCOPY" if !self.in_assembly => {
                return refuse(
                    format!("it makes nodes or elements with *{}", keyword.name),
                    "write the deck with every node and element in it: pre-processors do",
                );
            }
            "PART" => {
                self.parts += 1;
                if self.parts > 1 {
                    return refuse(
                        "it has several parts, whose numbers clash".into(),
                        "write a deck without parts and assemblies (a model attribute in Abaqus), or each part to a file",
                    );
                }
            }
            "ASSEMBLY" => self.in_assembly = true,
            "END ASSEMBLY" => self.in_assembly = false,
            "INSTANCE" => self.in_instance = true,
            "END INSTANCE" => self.in_instance = false,
            "SHELL SECTION" | "SHELL GENERAL SECTION" | "MEMBRANE SECTION" => {
                self.sections.push(Section {
                    set: keyword.get("ELSET").cloned().unwrap_or_default(),
                    thickness: f64::NAN,
                    is_nodal: keyword.has("NODAL THICKNESS"),
                    distribution: keyword.get("SHELL THICKNESS").cloned(),
                });
            }
            _ => {}
        }
        Ok(())
    }

    fn data(&mut self, keyword: &Keyword, line: &str, nth: usize) -> Result<(), ReadErrorKind> {
        // An assembly has nodes of its own, as reference points, with numbers that the part has too.
        if self.in_assembly && !self.in_instance {
            return Ok(());
        }
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        match keyword.name.as_str() {
            "INSTANCE"
                if fields
                    .iter()
                    .any(|f| f.parse::<f64>().is_ok_and(|x| x != 0.0)) =>
            {
                let note =
                    "the part is moved in its assembly: it is audited where its own nodes are";
                if !self.raw.notes.iter().any(|n| n == note) {
                    self.raw.notes.push(note.to_owned());
                }
            }
            "NODE" => self.node(&fields)?,
            "ELEMENT" => self.element(keyword, line, &fields)?,
            "ELSET" | "NSET" => {
                let name = keyword.get(&keyword.name).cloned().unwrap_or_default();
                let is_generated = keyword.has("GENERATE");
                let sets = match keyword.name.as_str() {
                    "ELSET" => &mut self.element_sets,
                    _ => &mut self.node_sets,
                };
                let members = set_members(sets, &fields, is_generated)?;
                sets.entry(name).or_default().extend(members);
            }
            "SHELL SECTION" | "SHELL GENERAL SECTION" | "MEMBRANE SECTION" => {
                let is_composite = keyword.has("COMPOSITE");
                if let Some(section) = self.sections.last_mut()
                    && (nth == 1 || is_composite)
                {
                    let layer = fields.first().and_then(|f| real(f)).unwrap_or(f64::NAN);
                    let below = if nth == 1 { 0.0 } else { section.thickness };
                    section.thickness = below + layer;
                }
            }
            "NODAL THICKNESS" => {
                let value = fields.get(1).and_then(|f| real(f));
                let value =
                    value.ok_or_else(|| expected("a node and its thickness", line.as_bytes()))?;
                let named = self.node_sets.get(&fields[0].to_ascii_uppercase());
                let nodes = match fields[0].parse() {
                    Ok(number) => vec![number],
                    Err(_) => named.cloned().unwrap_or_default(),
                };
                self.nodal.extend(nodes.into_iter().map(|n| (n, value)));
            }
            "DISTRIBUTION" => {
                let name = keyword.get("NAME").cloned().unwrap_or_default();
                let value = fields.get(1).and_then(|f| real(f)).unwrap_or(f64::NAN);
                let of = self.distributions.entry(name);
                let of = of.or_insert_with(|| (f64::NAN, HashMap::new()));
                match fields[0].parse() {
                    Ok(number) => drop(of.1.insert(number, value)),
                    Err(_) if fields[0].is_empty() => of.0 = value,
                    Err(_) => {
                        let members = self.element_sets.get(&fields[0].to_ascii_uppercase());
                        of.1.extend(members.into_iter().flatten().map(|n| (*n, value)));
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn node(&mut self, fields: &[&str]) -> Result<(), ReadErrorKind> {
        let number = whole(fields[0], "the number of a node")?;
        let mut at = [0.0; 3];
        for (x, field) in at.iter_mut().zip(&fields[1..]) {
            if !field.is_empty() {
                *x = real(field).ok_or_else(|| expected("a coordinate", field.as_bytes()))?;
            }
        }
        let at = DVec3::from_array(at);
        match self.numbers.add(number).map_err(|e| e.kind)? {
            None => self.raw.nodes.push((number, at)),
            Some(place) if self.raw.nodes[place as usize].1 == at => {}
            Some(_) => {
                return Err(ReadErrorKind::DefinedTwice {
                    what: "node",
                    number,
                });
            }
        }
        Ok(())
    }

    /// An element of many nodes goes on in the next line.
    fn element(
        &mut self,
        keyword: &Keyword,
        line: &str,
        fields: &[&str],
    ) -> Result<(), ReadErrorKind> {
        let kind = shape_of(keyword);
        for field in fields.iter().filter(|f| !f.is_empty()) {
            match (field.parse::<u64>(), kind) {
                (Ok(number), _) => self.pending.push(number),
                // Elements of other kinds may name sets and more.
                (Err(_), Shape::Other) => {}
                (Err(_), _) => return Err(expected("a node of an element", field.as_bytes())),
            }
        }
        let wanted = match kind {
            Shape::Shell { nodes, .. } | Shape::Solid { nodes } => nodes + 1,
            Shape::Other if line.trim_end().ends_with(',') => usize::MAX,
            Shape::Other => 0,
        };
        if self.pending.len() < wanted {
            return Ok(());
        }
        let numbers = std::mem::take(&mut self.pending);
        let Some((&number, nodes)) = numbers.split_first() else {
            return Ok(());
        };
        if let Some(set) = keyword.get("ELSET") {
            self.element_sets
                .entry(set.clone())
                .or_default()
                .push(number);
        }
        if !self.element_numbers.insert(number) && kind != Shape::Other {
            return Err(ReadErrorKind::DefinedTwice {
                what: "element",
                number,
            });
        }
        let place = |&node: &u64| self.numbers.get(node);
        match kind {
            Shape::Shell {
                corners,
                nodes: count,
            } => {
                let missing = |node| ReadErrorKind::MissingNode {
                    element: number,
                    node,
                };
                let places: Vec<u32> = (nodes[..count].iter())
                    .map(|n| place(n).ok_or_else(|| missing(*n)))
                    .collect::<Result<_, _>>()?;
                self.raw.shell(number, corners, &places, None);
            }
            Shape::Solid { .. } | Shape::Other => {
                let places: Vec<u32> = nodes.iter().filter_map(place).collect();
                places.into_iter().for_each(|n| self.raw.take(n));
                match kind {
                    Shape::Solid { .. } => self.raw.solids += 1,
                    _ => self.raw.others += 1,
                }
            }
        }
        Ok(())
    }

    /// What is pending when the next keyword comes is an element cut short.
    fn finish_element(&mut self, keyword: &Keyword) -> Result<(), ReadErrorKind> {
        let pending = std::mem::take(&mut self.pending);
        let is_other = shape_of(keyword) == Shape::Other;
        match pending.first().filter(|_| !is_other) {
            Some(number) => Err(ReadErrorKind::Counts(format!(
                "element {number} has too few nodes for its type"
            ))),
            None => Ok(()),
        }
    }

    fn thicken(&mut self) {
        let mut of_element: HashMap<u64, &Section> = HashMap::new();
        for section in &self.sections {
            for number in self.element_sets.get(&section.set).into_iter().flatten() {
                of_element.insert(*number, section);
            }
        }
        for element in &mut self.raw.elements {
            let Some(section) = of_element.get(&element.number) else {
                continue;
            };
            let table = section.distribution.as_ref();
            if let Some((usual, values)) = table.and_then(|name| self.distributions.get(name)) {
                let value = values.get(&element.number).unwrap_or(usual);
                element.thickness = [*value; 4];
            } else if section.is_nodal {
                for (to, node) in element.thickness.iter_mut().zip(&element.corners) {
                    let number = self.raw.nodes[*node as usize].0;
                    *to = self
                        .nodal
                        .get(&number)
                        .copied()
                        .unwrap_or(section.thickness);
                }
                if element.corners.len() == 3 {
                    element.thickness[3] = element.thickness[2];
                }
            } else {
                element.thickness = [section.thickness; 4];
            }
        }
    }
}

fn shape_of(keyword: &Keyword) -> Shape {
    keyword.get("TYPE").map_or(Shape::Other, |name| shape(name))
}

/// Members of a set: numbers, ranges, and the members of other sets.
fn set_members(
    sets: &HashMap<String, Vec<u64>>,
    fields: &[&str],
    is_generated: bool,
) -> Result<Vec<u64>, ReadErrorKind> {
    let fields: Vec<&str> = fields.iter().copied().filter(|f| !f.is_empty()).collect();
    if is_generated {
        let numbers: Vec<u64> = (fields.iter())
            .map(|f| whole(f, "a number of a range"))
            .collect::<Result<_, _>>()?;
        let [from, to] = [0, 1].map(|k| numbers.get(k).copied());
        let (Some(from), Some(to)) = (from, to) else {
            return Err(ReadErrorKind::Counts("a range lacks its end".into()));
        };
        let step = numbers.get(2).copied().unwrap_or(1).max(1);
        // More than any mesh has: a slip of the pen, not a set.
        if to.saturating_sub(from) / step > 100_000_000 {
            return Err(ReadErrorKind::Counts(format!(
                "the range {from} to {to} is too long"
            )));
        }
        return Ok((from..=to)
            .step_by(usize::try_from(step).unwrap_or(usize::MAX))
            .collect());
    }
    let mut members = Vec::new();
    for field in fields {
        match field.parse() {
            Ok(number) => members.push(number),
            Err(_) => members.extend(sets.get(&field.to_ascii_uppercase()).into_iter().flatten()),
        }
    }
    Ok(members)
}

fn whole(field: &str, what: &'static str) -> Result<u64, ReadErrorKind> {
    field.parse().map_err(|_| expected(what, field.as_bytes()))
}

/// A real number, with Fortran's exponents too.
fn real(field: &str) -> Option<f64> {
    field
        .parse()
        .ok()
        .or_else(|| field.replace(['d', 'D'], "e").parse().ok())
}
