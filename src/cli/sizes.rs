//! `--sizes`: a file with the sizes of single sheets and faces.

use super::complaint::Complaint;
use midshell::model::local_size::LocalSize;
use midshell::size_file;
use std::path::Path;

/// The sizes that the user wrote down; none without a file.
pub fn sizes(file: Option<&Path>) -> Result<Vec<LocalSize>, Complaint> {
    let Some(path) = file else {
        return Ok(Vec::new());
    };
    let what = || format!("cannot use the sizes {}", path.display());
    let text = std::fs::read_to_string(path).map_err(|e| {
        Complaint::usage(
            what(),
            format!("the file cannot be read: {e}"),
            "name a TOML file with entries such as [[size]], sheet = 3, size = 1.5",
        )
    })?;
    size_file::parse(&text, &path.display().to_string())
        .map_err(|e| Complaint::usage(what(), e.to_string(), e.remedy()))
}
