//! `--profile`: a name, or a file.

use super::args::CriteriaArgs;
use super::complaint::Complaint;
use midshell::criteria;
use midshell::model::profile::Profile;
use std::path::Path;

/// The criteria that the user chose.
pub fn profile(args: &CriteriaArgs) -> Result<Profile, Complaint> {
    let Some(choice) = args.profile.as_deref() else {
        return Ok(Profile::default());
    };
    match choice.to_str().and_then(Profile::named) {
        Some(profile) => Ok(profile),
        None => file(choice),
    }
}

fn file(path: &Path) -> Result<Profile, Complaint> {
    let what = || format!("cannot use the criteria {}", path.display());
    let text = std::fs::read_to_string(path).map_err(|e| {
        let remedy = format!("name one of {}, or a TOML file", Profile::NAMES.join(", "));
        Complaint::usage(
            what(),
            format!("it is no profile of that name, and the file cannot be read: {e}"),
            remedy,
        )
    })?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    criteria::parse(&text, &name).map_err(|e| Complaint::usage(what(), e.to_string(), e.remedy()))
}
