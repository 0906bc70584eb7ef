//! Outputs on the disk: all of them whole, or none.
//!
//! Every output is written to a temporary file in its own folder and brought to the disk (`fsync`); only then are all renamed to their names. If anything fails, the temporary files go,
//! and outputs that had already got their names are taken back: older files stand as they were.
//!
//! Limits: a process killed between two renames can leave the first output new and the second old; one killed earlier, a `.midshell-*.tmp` file.
//! A symbolic link is followed, the file that it points to is replaced. Devices and pipes are refused: renaming would replace them.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempPath};

/// Why the outputs were not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The folder of an output does not exist.
    #[error("cannot write {path}: there is no folder {folder}")]
    FolderMissing {
        /// The output.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The output names an existing folder.
    #[error("cannot write {path}: it is a folder")]
    IsFolder {
        /// The output.
        path: PathBuf,
    },
    /// The output names a device, a pipe or a socket.
    #[error("cannot write {path}: it is not a regular file")]
    NotAFile {
        /// The output.
        path: PathBuf,
    },
    /// Two outputs have one name.
    #[error("two outputs are named {path}")]
    NamedTwice {
        /// The output.
        path: PathBuf,
    },
    /// The folder or the file may not be written to.
    #[error("cannot write {path}: no rights to write there")]
    NoRights {
        /// The output.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The disk, the quota or the limit on file size is exhausted.
    #[error("cannot write {path}: no room for its {bytes} bytes")]
    NoRoom {
        /// The output.
        path: PathBuf,
        /// Its size.
        bytes: usize,
        /// What the system said.
        source: io::Error,
    },
    /// Anything else.
    #[error("cannot write {path}: {source}")]
    Other {
        /// The output.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

impl WriteError {
    /// The error of the system as one of ours.
    pub(crate) fn of(path: &Path, bytes: usize, source: io::Error) -> Self {
        let path = path.to_path_buf();
        match source.kind() {
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
                WriteError::NoRights { path, source }
            }
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
                WriteError::NoRoom {
                    path,
                    bytes,
                    source,
                }
            }
            ErrorKind::IsADirectory => WriteError::IsFolder { path },
            _ => WriteError::Other { path, source },
        }
    }
}

/// Links that are followed one after the other, as Linux does.
const LINKS: usize = 40;

/// Writes every output, or, with an error, none.
pub fn write_all(outputs: &[(PathBuf, Vec<u8>)]) -> Result<(), WriteError> {
    write_all_with(outputs, |file, bytes| file.write_all(bytes))
}

/// [`write_all`] with another way to fill a file: tests give one that runs into a full disk half-way.
pub fn write_all_with(
    outputs: &[(PathBuf, Vec<u8>)],
    mut fill: impl FnMut(&mut File, &[u8]) -> io::Result<()>,
) -> Result<(), WriteError> {
    let mut targets: Vec<PathBuf> = Vec::with_capacity(outputs.len());
    for (path, _) in outputs {
        let target = target(path)?;
        if targets.contains(&target) {
            return Err(WriteError::NamedTwice { path: path.clone() });
        }
        targets.push(target);
    }
    let mut filled = Vec::with_capacity(outputs.len());
    for ((path, bytes), target) in outputs.iter().zip(&targets) {
        let named = |e: io::Error| WriteError::of(path, bytes.len(), e);
        let mut file = temporary(target).map_err(named)?;
        fill(file.as_file_mut(), bytes).map_err(named)?;
        file.as_file().sync_all().map_err(named)?;
        // Closed here: some systems do not rename open files.
        filled.push(file.into_temp_path());
    }
    rename_all(outputs, &targets, filled)
}

/// Finds out whether an output could be written, and leaves nothing behind: better known before an hour's work than after it.
pub fn probe(path: &Path) -> Result<(), WriteError> {
    let target = target(path)?;
    temporary(&target)
        .map(drop)
        .map_err(|e| WriteError::of(path, 0, e))
}

/// The file that shall be replaced or made: in an existing folder, and not a folder, device or pipe.
fn target(path: &Path) -> Result<PathBuf, WriteError> {
    // A link to a file that is not there yet: the file is made, the link stays.
    let mut path = path.to_path_buf();
    for _ in 0..LINKS {
        match (fs::metadata(&path), fs::read_link(&path)) {
            (Err(e), Ok(to)) if e.kind() == ErrorKind::NotFound => path = folder_of(&path).join(to),
            _ => break,
        }
    }
    let path = path.as_path();
    let folder = folder_of(path);
    let at = || path.to_path_buf();
    match fs::metadata(folder) {
        Ok(data) if data.is_dir() => {}
        Err(e) if e.kind() == ErrorKind::PermissionDenied => {
            return Err(WriteError::of(path, 0, e));
        }
        Ok(_) | Err(_) => {
            return Err(WriteError::FolderMissing {
                path: at(),
                folder: folder.to_path_buf(),
            });
        }
    }
    match fs::metadata(path) {
        Ok(data) if data.is_dir() => Err(WriteError::IsFolder { path: at() }),
        Ok(data) if !data.is_file() => Err(WriteError::NotAFile { path: at() }),
        Ok(_) => fs::canonicalize(path).map_err(|e| WriteError::of(path, 0, e)),
        Err(e) if e.kind() == ErrorKind::NotFound => {
            let name = path
                .file_name()
                .ok_or_else(|| WriteError::IsFolder { path: at() })?;
            let folder = fs::canonicalize(folder).map_err(|e| WriteError::of(path, 0, e))?;
            Ok(folder.join(name))
        }
        Err(e) => Err(WriteError::of(path, 0, e)),
    }
}

/// The folder of a path; the current one if it names none.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// An empty temporary file beside `target`, with the rights that `target` has, or that a new file would get.
fn temporary(target: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".midshell-").suffix(".tmp");
    #[cfg(unix)]
    let rights = {
        use std::os::unix::fs::PermissionsExt;
        // The system takes the umask off this; a temporary file would else be its owner's alone.
        fs::Permissions::from_mode(0o666)
    };
    #[cfg(unix)]
    builder.permissions(rights);
    let file = builder.tempfile_in(folder_of(target))?;
    if let Ok(data) = fs::metadata(target) {
        if data.permissions().readonly() {
            // The folder would let us replace a file that its owner has closed to writing.
            return Err(ErrorKind::PermissionDenied.into());
        }
        file.as_file().set_permissions(data.permissions())?;
    }
    Ok(file)
}

/// Renames every temporary file to its target; if one fails, undoes those before it.
fn rename_all(
    outputs: &[(PathBuf, Vec<u8>)],
    targets: &[PathBuf],
    filled: Vec<TempPath>,
) -> Result<(), WriteError> {
    let mut done: Vec<(&PathBuf, Option<TempPath>)> = Vec::with_capacity(targets.len());
    for (k, (temporary, target)) in filled.into_iter().zip(targets).enumerate() {
        let (path, bytes) = &outputs[k];
        // Nothing can fail after the last rename: it needs no way back.
        let last = k + 1 == targets.len();
        let kept = if last { Ok(None) } else { keep(target) };
        let result = kept.and_then(|old| match temporary.persist(target) {
            Ok(()) => Ok(old),
            Err(e) => Err(e.error),
        });
        match result {
            Ok(old) => done.push((target, old)),
            Err(e) => {
                undo(done);
                return Err(WriteError::of(path, bytes.len(), e));
            }
        }
    }
    for target in targets {
        sync_folder(folder_of(target));
    }
    Ok(())
}

/// A second name for the file at `target`, if there is one, by which [`undo`] brings it back.
fn keep(target: &Path) -> io::Result<Option<TempPath>> {
    if !target.exists() {
        return Ok(None);
    }
    let spare = temporary(target)?.into_temp_path();
    fs::remove_file(&spare)?;
    // Some file systems know no hard links; a copy does as well.
    if fs::hard_link(target, &spare).is_err() {
        fs::copy(target, &spare)?;
    }
    Ok(Some(spare))
}

/// Puts back what stood under each name. Errors have no better place than the one already on its way to the caller.
fn undo(done: Vec<(&PathBuf, Option<TempPath>)>) {
    for (target, old) in done.into_iter().rev() {
        match old {
            Some(old) => drop(old.persist(target)),
            None => drop(fs::remove_file(target)),
        }
    }
}

/// Brings the new names to the disk. Not all systems can open a folder: then the names are as safe as any other.
fn sync_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        drop(folder.sync_all());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Name and content of every file in a folder, hidden ones too.
    fn listing(folder: &Path) -> Vec<(String, String)> {
        let mut files: Vec<(String, String)> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap())
            .filter(|entry| entry.path().is_file())
            .map(|entry| {
                let content = fs::read_to_string(entry.path()).unwrap();
                (entry.file_name().into_string().unwrap(), content)
            })
            .collect();
        files.sort();
        files
    }

    fn output(path: PathBuf, text: &str) -> (PathBuf, Vec<u8>) {
        (path, text.as_bytes().to_vec())
    }

    fn pairs(of: &[(&str, &str)]) -> Vec<(String, String)> {
        of.iter()
            .map(|(a, b)| (a.to_string(), b.to_string()))
            .collect()
    }

    #[test]
    fn outputs_are_made_and_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a.vtu"), "old").unwrap();
        write_all(&[output(at("a.vtu"), "new"), output(at("b.msh"), "made")]).unwrap();
        assert_eq!(
            listing(folder.path()),
            pairs(&[("a.vtu", "new"), ("b.msh", "made")])
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_leaves_everything_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a.vtu"), "old").unwrap();
        let outputs = [output(at("a.vtu"), "new"), output(at("b.msh"), "made")];
        let mut files = 0;
        let result = write_all_with(&outputs, |file, bytes| {
            files += 1;
            let (first, rest) = bytes.split_at(bytes.len() / 2);
            file.write_all(first)?;
            if files == 1 {
                return file.write_all(rest);
            }
            // The real error of a real full device.
            File::options()
                .write(true)
                .open("/dev/full")?
                .write_all(rest)
        });
        assert!(
            matches!(result, Err(WriteError::NoRoom { bytes: 4, .. })),
            "{result:?}"
        );
        assert_eq!(files, 2);
        assert_eq!(listing(folder.path()), pairs(&[("a.vtu", "old")]));
    }

    #[test]
    fn a_failed_rename_takes_earlier_ones_back() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a.vtu"), "old").unwrap();
        let outputs = [
            output(at("a.vtu"), "new"),
            output(at("b.msh"), "made"),
            output(at("c.bdf"), "made"),
        ];
        let blocked = at("c.bdf");
        let result = write_all_with(&outputs, |file, bytes| {
            // After the checks a folder appears under the name of the last output.
            fs::create_dir_all(&blocked)?;
            file.write_all(bytes)
        });
        assert!(
            matches!(result, Err(WriteError::IsFolder { .. })),
            "{result:?}"
        );
        assert_eq!(listing(folder.path()), pairs(&[("a.vtu", "old")]));
    }

    #[test]
    fn folders_that_are_missing_or_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "").unwrap();
        for place in ["none/a.vtu", "file/a.vtu"] {
            let result = write_all(&[output(at(place), "x")]);
            assert!(
                matches!(result, Err(WriteError::FolderMissing { .. })),
                "{result:?}"
            );
        }
        let result = write_all(&[output(folder.path().to_path_buf(), "x")]);
        assert!(
            matches!(result, Err(WriteError::IsFolder { .. })),
            "{result:?}"
        );
        let result = write_all(&[output(at("a"), "x"), output(at("./a"), "y")]);
        assert!(
            matches!(result, Err(WriteError::NamedTwice { .. })),
            "{result:?}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_probe_refuses_what_cannot_be_written_and_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "old").unwrap();
        assert!(probe(&at("new")).is_ok() && probe(&at("file")).is_ok());
        for bad in [at("none/out"), at("file/out"), folder.path().to_path_buf()] {
            assert!(probe(&bad).is_err(), "{}", bad.display());
        }
        assert_eq!(listing(folder.path()), pairs(&[("file", "old")]));
    }

    #[test]
    fn a_device_is_not_replaced() {
        let result = write_all(&[output(PathBuf::from("/dev/null"), "x")]);
        assert!(
            matches!(result, Err(WriteError::NotAFile { .. })),
            "{result:?}"
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn no_rights_is_named_for_root_too() {
        // Without a kernel behind it (some containers) the folder is one like any other.
        if Path::new("/sys/kernel").exists() {
            let result = write_all(&[output(PathBuf::from("/sys/midshell.vtu"), "x")]);
            assert!(
                matches!(result, Err(WriteError::NoRights { .. })),
                "{result:?}"
            );
        }
        let folder = tempfile::tempdir().unwrap();
        let closed = folder.path().join("closed.vtu");
        fs::write(&closed, "old").unwrap();
        let mut rights = fs::metadata(&closed).unwrap().permissions();
        rights.set_readonly(true);
        fs::set_permissions(&closed, rights).unwrap();
        let result = write_all(&[output(closed, "new")]);
        assert!(
            matches!(result, Err(WriteError::NoRights { .. })),
            "{result:?}"
        );
        assert_eq!(listing(folder.path()), pairs(&[("closed.vtu", "old")]));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_a_file_that_is_not_there_yet_stays_a_link() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        symlink("sub/second.vtu", at("first.vtu")).unwrap();
        symlink("new.vtu", at("sub/second.vtu")).unwrap();
        write_all(&[output(at("first.vtu"), "new")]).unwrap();
        assert_eq!(fs::read_to_string(at("sub/new.vtu")).unwrap(), "new");
        for link in ["first.vtu", "sub/second.vtu"] {
            assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink());
        }
        // Round in a circle there is no file.
        symlink("round.vtu", at("round.vtu")).unwrap();
        assert!(write_all(&[output(at("round.vtu"), "new")]).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn rights_and_links_of_an_older_file_are_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("real.vtu"), "old").unwrap();
        fs::set_permissions(at("real.vtu"), fs::Permissions::from_mode(0o640)).unwrap();
        symlink(at("real.vtu"), at("link.vtu")).unwrap();
        write_all(&[output(at("link.vtu"), "new")]).unwrap();
        assert!(fs::symlink_metadata(at("link.vtu")).unwrap().is_symlink());
        let mode = fs::metadata(at("real.vtu")).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
        assert_eq!(fs::read_to_string(at("real.vtu")).unwrap(), "new");
    }
}
