//! `midshell audit`.

use super::args::AuditArgs;
use super::commands::{is_stdout, json_file, refuse_clashes, to_json, with_threads};
use super::complaint::Complaint;
use super::console::{self, Reporter};
use super::profile::profile;
use midshell::exit_class::ExitClass;
use midshell::export::{self, Format};
use midshell::options::MeshOptions;
use midshell::pipeline::{self, MeshAudit};
use std::path::PathBuf;

/// Judges a mesh. Outputs are written whatever the verdict is.
pub fn audit(args: &AuditArgs) -> Result<ExitClass, Complaint> {
    let mesh = &args.mesh;
    let options = MeshOptions {
        profile: profile(&args.criteria)?,
        ..args.options()
    };
    options
        .check()
        .map_err(|fault| Complaint::options("audit", mesh, &fault))?;
    let outputs = outputs(args)?;
    refuse_clashes(mesh, &outputs)?;
    if let Some(solid) = &args.solid {
        refuse_clashes(solid, &outputs)?;
    }
    for path in outputs {
        export::probe(path).map_err(|e| Complaint::output(mesh, &e))?;
    }
    let reporter = Reporter::new(mesh, args.run.quiet, args.run.verbose);
    let done = with_threads(&args.run, || {
        pipeline::audit_mesh(mesh, args.solid.as_deref(), &options, &reporter)
    })?;
    reporter.finish();
    let done = done.map_err(|e| Complaint::pipeline("audit", mesh, &e))?;
    deliver(args, &done)?;
    Ok(match done.report.faults.is_empty() {
        true => ExitClass::Right,
        false => ExitClass::Doubted,
    })
}

/// Every file that shall be written.
fn outputs(args: &AuditArgs) -> Result<Vec<&PathBuf>, Complaint> {
    if let Some(path) = &args.output {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        if Format::from_extension(&extension) != Some(Format::Vtu) {
            return Err(Complaint::usage(
                format!("cannot write {}", path.display()),
                "the failing elements are written as VTU, with a field for each criterion",
                "end its name with .vtu",
            ));
        }
    }
    let files = args.output.iter().chain(&args.csv);
    Ok(files.chain(json_file(&args.json)).collect())
}

fn deliver(args: &AuditArgs, done: &MeshAudit) -> Result<(), Complaint> {
    let json = to_json(&done.report)?;
    let mut outputs = Vec::new();
    if let Some(path) = &args.output {
        outputs.push((path.clone(), done.failing()));
    }
    if let Some(path) = &args.csv {
        outputs.push((path.clone(), done.csv()));
    }
    if let Some(path) = json_file(&args.json) {
        outputs.push((path.clone(), json.clone().into_bytes()));
    }
    export::write_all(&outputs).map_err(|e| Complaint::output(&args.mesh, &e))?;
    if is_stdout(&args.json) {
        return console::result(&json);
    }
    if args.run.quiet {
        return Ok(());
    }
    let mut text = done.text();
    for (path, _) in &outputs {
        text.push_str(&format!("wrote {}\n", path.display()));
    }
    match console::result(&text) {
        // The files are there: a terminal that takes no more is no reason to hide the verdict.
        Err(complaint) if !outputs.is_empty() => {
            console::message(&format!(
                "warning: {}: {}\n",
                complaint.what, complaint.cause
            ));
            Ok(())
        }
        told => told,
    }
}
