//! Every flag of the command line, once. No flag holds a default value: those are the library's.

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueHint};
use clap_complete::Shell;
use midshell::exit_class::ExitClass;
use midshell::model::element_shape::ElementShape;
use midshell::model::keep::KeepEdge;
use midshell::model::length_unit::LengthUnit;
use midshell::model::metric::{QUAD_METRICS, TRIANGLE_METRICS, bare};
use midshell::model::profile::Profile;
use midshell::model::removal::SmallLimits;
use midshell::model::washer::WasherRequest;
use midshell::options::MeshOptions;
use std::path::PathBuf;
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  midshell mesh bracket.step -o bracket.inp
  midshell mesh cover.step -o cover.vtu -o cover.bdf --size 4 --element quad --json cover.json
  midshell mesh panel.step -o panel.bdf --element quad --washer 2 --washer-holes 4..12
  midshell mesh scan.stl -o scan.vtu
  midshell mesh hood.step -o hood.inp --format abaqus --size-curvature 24 --timings
  midshell mesh cover.step -o cover.vtu --size-min 1 --size-max 8 --growth 1.2 --rows 3 --sizes sizes.toml
  midshell inspect bracket.step
  midshell audit bracket.inp --solid bracket.step
  midshell audit door.bdf --profile crash --csv door.csv -o failing.vtu
  midshell doctor
  midshell completions bash > ~/.local/share/bash-completion/completions/midshell";

/// A thin-walled solid in (STEP, IGES, BREP; STL, OBJ, PLY), a connected shell mesh on its mid-surface with thickness out.
#[derive(Parser, Debug)]
#[command(name = "midshell", version, arg_required_else_help = true, after_help = after_help())]
pub struct Cli {
    #[command(subcommand)]
    pub command: Verb,
}

#[derive(Subcommand, Debug)]
pub enum Verb {
    /// Mesh the mid-surface of a part
    #[command(after_help = after_help())]
    Mesh(Box<MeshArgs>),
    /// Show what a part is made of: solids, faces, walls, thickness, sheets, junctions, lumps
    Inspect(InspectArgs),
    /// Judge a shell mesh, whoever made it: element quality, free edges, T-connections, duplicates, normals; against its solid, if that is given
    #[command(after_help = audit_help())]
    Audit(AuditArgs),
    /// Show which gmsh would run, what is missing, and the command that mends it
    Doctor(DoctorArgs),
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: Shell,
    },
}

/// What is read, and with which tool.
#[derive(Args, Debug)]
pub struct SourceArgs {
    /// The part: a CAD file (STEP, IGES, BREP) or closed facets (STL, OBJ, PLY; lengths in --unit)
    #[arg(value_name = "IN", value_hint = ValueHint::FilePath)]
    pub input: PathBuf,
    #[command(flatten)]
    pub run: RunArgs,
}

/// How a part is read, and how much is said.
#[derive(Args, Debug)]
pub struct RunArgs {
    /// Unit of the lengths in a STL, OBJ or PLY file, which names none [default: mm]
    #[arg(long, value_parser = units())]
    pub unit: Option<String>,
    #[command(flatten)]
    pub tool: ToolArgs,
    /// Longest that the import may take, in seconds of processor time; four times as long by the clock [default: 58]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = seconds)]
    pub time_limit: Option<Duration>,
    /// Threads to work with [default: one a core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Say what is being done, with times
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,
}

/// Which gmsh.
#[derive(Args, Debug)]
pub struct ToolArgs {
    /// The gmsh command [default: MIDSHELL_GMSH, then the PATH]
    #[arg(long, value_name = "PATH", value_hint = ValueHint::ExecutablePath)]
    pub gmsh: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub struct MeshArgs {
    /// A file to write; the format follows from its extension. May be given several times
    #[arg(short, long = "output", value_name = "OUT", required = true, value_hint = ValueHint::FilePath)]
    pub outputs: Vec<PathBuf>,
    /// Edge length of the elements, in mm [default: from the part's thickness and features]
    #[arg(long, value_name = "H", allow_hyphen_values = true)]
    pub size: Option<f64>,
    /// Elements in a full turn of a curved wall [default: as many as keep the mesh near the mid-surface, to half a percent of the thickness]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub size_curvature: Option<f64>,
    /// No shorter edges are wanted anywhere, in mm: bends, steps and narrow places give way [default: no bound]
    #[arg(long, value_name = "H", allow_hyphen_values = true)]
    pub size_min: Option<f64>,
    /// No longer edges are wanted anywhere, in mm, also where the part decides [default: no bound]
    #[arg(long, value_name = "H", allow_hyphen_values = true)]
    pub size_max: Option<f64>,
    /// Factor by which neighbouring edges may differ in length [default: 1.3, and 1.4 from row to row within a sheet]
    #[arg(long, value_name = "G", allow_hyphen_values = true)]
    pub growth: Option<f64>,
    /// Rows of elements across a rib, flange or web; fewer where they would be lower than it is thick [default: 2]
    #[arg(long, value_name = "N")]
    pub rows: Option<u32>,
    /// Sizes of single sheets and faces, as a TOML file with entries such as [[size]] sheet = 3 (or face = [12, 14]) size = 1.5
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub sizes: Option<PathBuf>,
    /// Keep the edges between two faces on one side of a wall as lines of element edges: the numbers of the faces as in 'midshell inspect'. May be given several times [default: the mesh knows no such edge]
    #[arg(long, value_name = "A-B", allow_hyphen_values = true)]
    pub keep_edge: Vec<KeepEdge>,
    /// The elements to make [default: tri]
    #[arg(long, value_parser = shapes())]
    pub element: Option<String>,
    /// Fill holes whose rim is shorter than that of a round hole of this diameter, in mm; for a round hole that is its diameter, for a slot W wide and L long W + 0.64 (L - W) [default: no hole]
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    pub min_hole: Option<f64>,
    /// Flatten what stands out of a wall or is sunk into it, if it is less high than this and fits into a circle of this diameter, in mm: logos, embossings, pockets [default: nothing]
    #[arg(long, value_name = "H", allow_hyphen_values = true)]
    pub min_feature: Option<f64>,
    #[command(flatten)]
    pub washers: WasherArgs,
    #[arg(long, value_name = "F", help = format_help())]
    pub format: Option<String>,
    #[command(flatten)]
    pub criteria: CriteriaArgs,
    /// Write the report as JSON; - is the terminal
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub json: Option<PathBuf>,
    /// Show how long each stage took, and the most memory
    #[arg(long)]
    pub timings: bool,
    /// Keep the result of every stage in this folder, to look into a run that went wrong
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub dump: Option<PathBuf>,
    #[command(flatten)]
    pub source: SourceArgs,
}

/// Rings of quads round holes.
#[derive(Args, Debug)]
pub struct WasherArgs {
    /// Rings of quads round the holes of bolts, as many quads in each [default: 0]
    #[arg(long, value_name = "N")]
    pub washer: Option<u32>,
    /// Diameters of the holes that get a washer, in mm, from and to [default: round holes of up to four edge lengths]
    #[arg(long, value_name = "MIN..MAX", allow_hyphen_values = true, value_parser = range)]
    pub washer_holes: Option<Range>,
    /// Width of one ring, in mm; what does not fit is an error [default: the washer twice as wide as its hole, a ring no wider than an element, less where room is scarce]
    #[arg(long, value_name = "W", allow_hyphen_values = true)]
    pub washer_width: Option<f64>,
}

/// From and to.
#[derive(Clone, Copy, Debug)]
pub struct Range(pub [f64; 2]);

/// What elements are held against.
#[derive(Args, Debug)]
pub struct CriteriaArgs {
    /// The criteria: shell, crash, or a TOML file with limits that stand on top of one of these [default: shell]
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub profile: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub struct AuditArgs {
    /// The mesh: .vtu, .msh, .inp (Abaqus, CalculiX), .bdf (.nas, .fem) or .stl
    #[arg(value_name = "MESH", value_hint = ValueHint::FilePath)]
    pub mesh: PathBuf,
    /// The solid that the mesh stands for, a CAD file or closed facets: distance to both sides, area covered, topology and mass are held against it
    #[arg(long, value_name = "PART", value_hint = ValueHint::FilePath)]
    pub solid: Option<PathBuf>,
    #[command(flatten)]
    pub criteria: CriteriaArgs,
    /// Edge length that was asked for, in mm: the shortest edges are held against it [default: no edge is too short]
    #[arg(long, value_name = "H", allow_hyphen_values = true)]
    pub size: Option<f64>,
    /// Write the elements that break a criterion as VTU, with a field a criterion
    #[arg(short, long = "output", value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,
    /// Write the report as JSON; - is the terminal
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub json: Option<PathBuf>,
    /// Write every metric of every element as CSV
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub csv: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Args, Debug)]
pub struct InspectArgs {
    /// Write the findings as JSON; - is the terminal
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub json: Option<PathBuf>,
    #[command(flatten)]
    pub source: SourceArgs,
}

#[derive(Args, Debug)]
pub struct DoctorArgs {
    #[command(flatten)]
    pub tool: ToolArgs,
}

impl RunArgs {
    /// The library's options with what the user chose.
    pub fn options(&self) -> MeshOptions {
        let mut options = MeshOptions {
            // clap let only known names through.
            unit: self.unit.as_deref().and_then(|name| name.parse().ok()),
            gmsh: self.tool.gmsh.clone(),
            ..MeshOptions::default()
        };
        if let Some(limit) = self.time_limit {
            options.time_limit = limit;
        }
        options
    }
}

impl MeshArgs {
    /// The library's options with what the user chose.
    pub fn options(&self) -> MeshOptions {
        let mut options = MeshOptions {
            size: self.size,
            size_curvature: self.size_curvature,
            small: SmallLimits {
                hole: self.min_hole,
                feature: self.min_feature,
            },
            size_min: self.size_min,
            size_max: self.size_max,
            growth: self.growth,
            dump: self.dump.clone(),
            washer: self.washers.request(),
            keep: self.keep_edge.clone(),
            ..self.source.run.options()
        };
        options.rows = self.rows.unwrap_or(options.rows);
        // clap let only known names through.
        if let Some(shape) = self.element.as_deref().and_then(|name| name.parse().ok()) {
            options.element = shape;
        }
        options
    }
}

impl WasherArgs {
    fn request(&self) -> WasherRequest {
        let mut request = WasherRequest {
            holes: self.washer_holes.map(|r| r.0),
            width: self.washer_width,
            ..WasherRequest::default()
        };
        if let Some(layers) = self.washer {
            request.layers = layers;
        }
        request
    }
}

impl AuditArgs {
    /// The library's options with what the user chose.
    pub fn options(&self) -> MeshOptions {
        MeshOptions {
            size: self.size,
            ..self.run.options()
        }
    }
}

fn format_help() -> String {
    format!(
        "The dialect where an extension has several (.inp), or the format of outputs whose extension says nothing: {}",
        super::format::names()
    )
}

fn shapes() -> PossibleValuesParser {
    PossibleValuesParser::new(ElementShape::NAMED.iter().map(|(name, _)| *name))
}

fn units() -> PossibleValuesParser {
    PossibleValuesParser::new(LengthUnit::NAMED.iter().map(|(name, _)| *name))
}

fn range(text: &str) -> Result<Range, String> {
    let number = |part: &str| part.trim().parse::<f64>().ok();
    let ends = text.split_once("..").map(|(a, b)| [number(a), number(b)]);
    match ends {
        Some([Some(from), Some(to)]) => Ok(Range([from, to])),
        _ => Err("not a range such as 4..12".into()),
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number of seconds")?;
    Duration::try_from_secs_f64(seconds).map_err(|e| e.to_string())
}

/// Examples and the exit statuses, below every long help.
fn after_help() -> String {
    format!("{EXAMPLES}\n\n{}", statuses())
}

/// The limits that a criteria file may name, and the exit statuses.
fn audit_help() -> String {
    let names = |list: &[&'static str]| {
        let names: Vec<&str> = list.iter().map(|n| bare(n)).collect();
        names.join(", ")
    };
    format!(
        "{EXAMPLES}\n\nA criteria file (TOML) may hold: name, base ({}), edge_ratio_max, warp_deg_max, skew_deg_max, scaled_jacobian_min, quad_angle_deg = [from, to], \
         triangle_angle_deg = [from, to], triangle_share_max, shortest_edge_min (over --size),\nand below [quad] or [triangle] any metric as NAME = {{ min = A, max = B }}:\n  \
         quad: {}\n  triangle: {}\n\n{}",
        Profile::NAMES.join(" or "),
        names(&QUAD_METRICS),
        names(&TRIANGLE_METRICS),
        statuses()
    )
}

fn statuses() -> String {
    let mut text = String::from("Exit status:\n");
    for class in ExitClass::ALL {
        text.push_str(&format!("  {:>2}  {}\n", class.code(), class.meaning()));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_flags_do_not_contradict_each_other() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_bare_command_line_changes_no_default() {
        let cli = Cli::try_parse_from(["midshell", "mesh", "a.step", "-o", "a.inp"]).unwrap();
        let Verb::Mesh(args) = cli.command else {
            panic!("not mesh")
        };
        assert_eq!(args.options(), MeshOptions::default());
    }

    #[test]
    fn an_audit_holds_edges_against_the_size_and_leaves_the_rest() {
        let options = |line: &str| {
            let cli = Cli::try_parse_from(line.split(' ')).unwrap();
            let Verb::Audit(args) = cli.command else {
                panic!("not audit")
            };
            args.options()
        };
        assert_eq!(options("midshell audit a.inp"), MeshOptions::default());
        let want = MeshOptions {
            size: Some(5.0),
            unit: Some(LengthUnit::Inch),
            ..MeshOptions::default()
        };
        let line = "midshell audit a.inp --solid a.stl --unit in --size 5";
        assert_eq!(options(line), want);
    }

    #[test]
    fn every_choice_reaches_the_library() {
        let line = "midshell mesh a.step -o a.inp --size -2.5 --size-curvature 24 --size-min 1 --size-max 9 --growth 1.2 --rows 3 --keep-edge 3-7 --keep-edge 12-4 --element quad --min-hole 4 --min-feature 1.5 --washer 2 --washer-holes 4..12.5 --washer-width 1.5 --unit in --gmsh /g --time-limit 1.5 --dump d";
        let cli = Cli::try_parse_from(line.split(' ')).unwrap();
        let Verb::Mesh(args) = cli.command else {
            panic!("not mesh")
        };
        let want = MeshOptions {
            size: Some(-2.5),
            size_curvature: Some(24.0),
            size_min: Some(1.0),
            size_max: Some(9.0),
            growth: Some(1.2),
            rows: 3,
            keep: [[3, 7], [12, 4]].map(|faces| KeepEdge { faces }).into(),
            element: ElementShape::Quad,
            small: SmallLimits {
                hole: Some(4.0),
                feature: Some(1.5),
            },
            washer: WasherRequest {
                layers: 2,
                holes: Some([4.0, 12.5]),
                width: Some(1.5),
            },
            unit: Some(LengthUnit::Inch),
            gmsh: Some("/g".into()),
            time_limit: Duration::from_millis(1500),
            dump: Some("d".into()),
            ..MeshOptions::default()
        };
        assert_eq!(args.options(), want);
    }

    #[test]
    fn what_is_no_range_is_refused() {
        for good in ["4..12", "4 .. 12", "-1..0.5", "12..4"] {
            assert!(range(good).is_ok(), "{good}");
        }
        for bad in ["", "4", "4-12", "..", "4..", "..12", "a..b", "4..8..12"] {
            assert!(range(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn help_tells_the_defaults_that_the_library_has() {
        let defaults = MeshOptions::default();
        let help = Cli::command()
            .find_subcommand_mut("mesh")
            .unwrap()
            .render_long_help()
            .to_string();
        // Where its lines break depends on the terminal.
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(help.contains(&format!("[default: {}]", defaults.element)));
        let rows = format!("than it is thick [default: {}]", defaults.rows);
        assert!(help.contains(&rows), "{rows} not in\n{help}");
        let profile = format!("of one of these [default: {}]", defaults.profile.name);
        assert!(help.contains(&profile), "{profile} not in\n{help}");
        let limit = format!("by the clock [default: {}]", defaults.time_limit.as_secs());
        assert!(help.contains(&limit), "{limit} not in\n{help}");
        let rings = format!("quads in each [default: {}]", defaults.washer.layers);
        assert!(help.contains(&rings), "{rings} not in\n{help}");
        assert!(help.contains("up to four edge lengths") && WasherRequest::HOLE_SIZES == 4.0);
        let unit = format!("names none [default: {}]", LengthUnit::default());
        assert!(help.contains(&unit), "{unit} not in\n{help}");
    }
}
