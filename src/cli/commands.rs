//! One function a verb.

use super::args::{Cli, DoctorArgs, InspectArgs, MeshArgs, RunArgs, Verb};
use super::audit::audit;
use super::complaint::Complaint;
use super::console::{self, Reporter};
use super::format::format_of;
use super::profile::profile;
use super::sizes::sizes;
use clap::CommandFactory;
use midshell::doctor;
use midshell::exit_class::ExitClass;
use midshell::export::{self, ExportOptions, Format};
use midshell::options::MeshOptions;
use midshell::pipeline::{self, MeshRun};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The path that stands for standard output.
const STDOUT: &str = "-";

/// Does what the command line says.
pub fn run(cli: &Cli) -> Result<ExitClass, Complaint> {
    match &cli.command {
        Verb::Mesh(args) => mesh(args),
        Verb::Inspect(args) => inspect(args),
        Verb::Audit(args) => audit(args),
        Verb::Doctor(args) => examine(args),
        Verb::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "midshell", &mut script);
            console::result(&String::from_utf8_lossy(&script))?;
            Ok(ExitClass::Right)
        }
    }
}

fn mesh(args: &MeshArgs) -> Result<ExitClass, Complaint> {
    let input = &args.source.input;
    let options = MeshOptions {
        profile: profile(&args.criteria)?,
        sizes: sizes(args.sizes.as_deref())?,
        ..args.options()
    };
    options
        .check()
        .map_err(|fault| Complaint::options("mesh", input, &fault))?;
    let formats = args
        .outputs
        .iter()
        .map(|path| format_of(path, args.format.as_deref()))
        .collect::<Result<Vec<_>, _>>()?;
    let files: Vec<&PathBuf> = args.outputs.iter().chain(json_file(&args.json)).collect();
    refuse_clashes(input, &files)?;
    for path in files {
        export::probe(path).map_err(|e| Complaint::output(input, &e))?;
    }

    let reporter = Reporter::new(input, args.source.run.quiet, args.source.run.verbose);
    let run = with_threads(&args.source.run, || {
        pipeline::mesh(input, &options, &reporter)
    })?;
    reporter.finish();
    let run = run.map_err(|e| Complaint::pipeline("mesh", input, &e))?;

    let mut outputs = render(args, &formats, &run)?;
    let json = to_json(&run.report)?;
    if let Some(path) = json_file(&args.json) {
        outputs.push((path.clone(), json.clone().into_bytes()));
    }
    export::write_all(&outputs).map_err(|e| Complaint::output(input, &e))?;
    // The files are there: a terminal that takes no more is no reason to call the run failed, nor to hide a doubt.
    match tell(args, &run, &json) {
        Err(complaint) if !is_stdout(&args.json) => {
            console::message(&format!(
                "warning: {}: {}\n",
                complaint.what, complaint.cause
            ));
        }
        told => told?,
    }
    if run.report.doubts.is_empty() {
        return Ok(ExitClass::Right);
    }
    console::message(&format!(
        "warning: the audit doubts the mesh of {}\n",
        input.display()
    ));
    for doubt in &run.report.doubts {
        console::message(&format!("  {doubt}\n"));
    }
    Ok(ExitClass::Doubted)
}

/// The contents of every output.
fn render(
    args: &MeshArgs,
    formats: &[Format],
    run: &MeshRun,
) -> Result<Vec<(PathBuf, Vec<u8>)>, Complaint> {
    let name = args.source.input.file_name().unwrap_or_default();
    let options = ExportOptions {
        title: name.to_string_lossy().into_owned(),
        cell_quality: Some(&run.cell_quality),
        cell_doubts: run.report.audit.as_ref().map(|a| &a.element_doubts[..]),
        ..ExportOptions::default()
    };
    args.outputs
        .iter()
        .zip(formats)
        .map(
            |(path, format)| match export::render(*format, &run.mesh, &options) {
                Ok(bytes) => Ok((path.clone(), bytes)),
                // The pipeline gave a mesh that no solver takes: its fault, not the user's.
                Err(e) => Err(Complaint::bug(&format!("{}: {e}", path.display()))),
            },
        )
        .collect()
}

/// What a finished run puts on standard output.
fn tell(args: &MeshArgs, run: &MeshRun, json: &str) -> Result<(), Complaint> {
    let mut text = String::new();
    if is_stdout(&args.json) {
        text.push_str(json);
    } else if !args.source.run.quiet {
        text.push_str(&run.report.to_string());
        for path in &args.outputs {
            text.push_str(&format!("wrote {}\n", path.display()));
        }
    }
    console::result(&text)?;
    if args.timings {
        let memory = run.report.peak_memory;
        let table = timing_table(&run.timings) + &format!("peak memory {memory}\n");
        // Standard output holds nothing but JSON when it is asked for.
        if is_stdout(&args.json) {
            console::message(&table);
        } else {
            console::result(&table)?;
        }
    }
    Ok(())
}

fn timing_table(timings: &[(String, f64)]) -> String {
    let total: f64 = timings.iter().map(|t| t.1).sum();
    let width = timings.iter().map(|t| t.0.len()).max().unwrap_or(0).max(5);
    let mut text = String::from("timings (s)\n");
    for (stage, seconds) in timings {
        text.push_str(&format!("  {stage:<width$}  {seconds:>9.3}\n"));
    }
    text.push_str(&format!("  {:<width$}  {total:>9.3}\n", "total"));
    text
}

fn inspect(args: &InspectArgs) -> Result<ExitClass, Complaint> {
    let input = &args.source.input;
    let options = args.source.run.options();
    options
        .check()
        .map_err(|fault| Complaint::options("inspect", input, &fault))?;
    let file = json_file(&args.json);
    refuse_clashes(input, &file.iter().copied().collect::<Vec<_>>())?;
    if let Some(path) = file {
        export::probe(path).map_err(|e| Complaint::output(input, &e))?;
    }
    let reporter = Reporter::new(input, args.source.run.quiet, args.source.run.verbose);
    let found = with_threads(&args.source.run, || {
        pipeline::inspect(input, &options, &reporter)
    })?;
    reporter.finish();
    let found = found.map_err(|e| Complaint::pipeline("inspect", input, &e))?;
    let json = to_json(&found)?;
    if let Some(path) = file {
        let output = (path.clone(), json.clone().into_bytes());
        export::write_all(&[output]).map_err(|e| Complaint::output(input, &e))?;
    }
    if is_stdout(&args.json) {
        console::result(&json)?;
    } else if !args.source.run.quiet {
        console::result(&found.to_string())?;
    }
    Ok(ExitClass::Right)
}

fn examine(args: &DoctorArgs) -> Result<ExitClass, Complaint> {
    let findings = doctor::examine(args.tool.gmsh.as_deref());
    let width = findings.iter().map(|f| f.what.len()).max().unwrap_or(0);
    let mut text = String::new();
    for finding in &findings {
        let mark = match (&finding.remedy, finding.optional) {
            (None, _) => "ok",
            (Some(_), true) => "--",
            (Some(_), false) => "!!",
        };
        text.push_str(&format!(
            "{mark}  {:<width$}  {}\n",
            finding.what, finding.found
        ));
        if let Some(remedy) = &finding.remedy {
            text.push_str(&format!("    {:<width$}  mend it: {remedy}\n", ""));
        }
    }
    console::result(&text)?;
    Ok(
        if findings.iter().all(|f| f.remedy.is_none() || f.optional) {
            ExitClass::Right
        } else {
            ExitClass::ToolFailed
        },
    )
}

/// Runs `work` in a pool of the size that the user asked for.
pub(super) fn with_threads<T: Send>(
    run: &RunArgs,
    work: impl FnOnce() -> T + Send,
) -> Result<T, Complaint> {
    let Some(count) = run.threads else {
        return Ok(work());
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(count))
        .build();
    match pool {
        Ok(pool) => Ok(pool.install(work)),
        Err(e) => Err(Complaint::usage(
            format!("cannot start {count} threads"),
            e.to_string(),
            "ask for fewer with --threads",
        )),
    }
}

/// An output that is the input, or another output, would destroy it.
pub(super) fn refuse_clashes(input: &Path, outputs: &[&PathBuf]) -> Result<(), Complaint> {
    // Files that are not there yet have no canonical path: they are compared by their folder's.
    let place = |path: &Path| {
        path.canonicalize().ok().or_else(|| {
            let folder = match path.parent() {
                Some(folder) if !folder.as_os_str().is_empty() => folder,
                _ => Path::new("."),
            };
            Some(folder.canonicalize().ok()?.join(path.file_name()?))
        })
    };
    for (i, path) in outputs.iter().enumerate() {
        let clash = |other: &Path| place(path).is_some_and(|p| Some(p) == place(other));
        if clash(input) {
            return Err(Complaint::usage(
                format!("cannot write {}", path.display()),
                "it is the input",
                "give the output another name",
            ));
        }
        if outputs[..i].iter().any(|other| clash(other)) {
            return Err(Complaint::usage(
                format!("cannot write {}", path.display()),
                "two outputs have this name",
                "give each output its own name",
            ));
        }
    }
    Ok(())
}

pub(super) fn json_file(json: &Option<PathBuf>) -> Option<&PathBuf> {
    json.as_ref().filter(|path| path.as_os_str() != STDOUT)
}

pub(super) fn is_stdout(json: &Option<PathBuf>) -> bool {
    json.as_ref().is_some_and(|path| path.as_os_str() == STDOUT)
}

pub(super) fn to_json(value: &impl Serialize) -> Result<String, Complaint> {
    match serde_json::to_string_pretty(value) {
        Ok(text) => Ok(text + "\n"),
        Err(e) => Err(Complaint::bug(&e.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_that_would_destroy_each_other_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("in.step"), "").unwrap();
        let (a, b, roundabout) = (at("a.vtu"), at("b.vtu"), folder.path().join("./a.vtu"));
        assert!(refuse_clashes(&at("in.step"), &[&a, &b]).is_ok());
        assert!(refuse_clashes(&at("in.step"), &[&a, &roundabout]).is_err());
        assert!(refuse_clashes(&at("in.step"), &[&a, &at("in.step")]).is_err());
    }

    #[test]
    fn timings_add_up() {
        let table = timing_table(&[("import".into(), 1.5), ("pair".into(), 0.25)]);
        assert!(table.ends_with("  total       1.750\n"), "{table}");
    }

    #[test]
    fn the_pool_has_the_size_asked_for() {
        let line = "midshell mesh a -o a.vtu --threads 3".split(' ');
        let cli = <Cli as clap::Parser>::try_parse_from(line).unwrap();
        let Verb::Mesh(args) = cli.command else {
            panic!("not mesh")
        };
        assert_eq!(
            with_threads(&args.source.run, rayon::current_num_threads),
            Ok(3)
        );
    }
}
