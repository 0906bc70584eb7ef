//! Results reach the disk whole or not at all.
//!
//! Guarantees: every file is first written beside its target under a temporary name and flushed, and only when all are there are they renamed; where
//! anything fails, no file of this run is left behind. A link is followed, a write-protected file is left alone.
//! Limits: a file that was there before and is already replaced when a later rename fails does not come back. A device or a pipe (`/dev/stdout`) cannot
//! be renamed over: it is written straight, after all files are on the disk.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// An output that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}", path.display())]
pub struct DeliveryError {
    /// The output.
    pub path: PathBuf,
    /// Why not.
    #[source]
    pub cause: io::Error,
}

/// Where one output goes.
enum Target {
    /// A regular file, there or not, in a folder that is.
    File { path: PathBuf, folder: PathBuf },
    /// Something that is written straight.
    Device(PathBuf),
}

/// Finds out whether an output could be written, without leaving anything behind: better known before the work than after it.
pub fn probe(path: &Path) -> Result<(), DeliveryError> {
    let probe = || match target(path)? {
        Target::File { folder, .. } => tempfile::tempfile_in(folder).map(drop),
        Target::Device(_) => Ok(()),
    };
    probe().map_err(|cause| failed(path, cause))
}

/// Writes all outputs, or none.
pub fn deliver(outputs: &[(PathBuf, Vec<u8>)]) -> Result<(), DeliveryError> {
    let mut staged = Vec::new();
    let mut devices = Vec::new();
    for (asked, bytes) in outputs {
        match target(asked).map_err(|e| failed(asked, e))? {
            Target::File { path, folder } => {
                let file = stage(&folder, bytes).map_err(|e| failed(asked, e))?;
                staged.push((path, file));
            }
            Target::Device(path) => devices.push((asked, path, bytes)),
        }
    }
    for (asked, path, bytes) in devices {
        write_straight(&path, bytes).map_err(|e| failed(asked, e))?;
    }
    publish(staged)
}

/// Gives the staged files their names.
fn publish(staged: Vec<(PathBuf, NamedTempFile)>) -> Result<(), DeliveryError> {
    let mut fresh: Vec<PathBuf> = Vec::new();
    for (path, file) in staged {
        let is_new = !path.exists();
        match file.persist(&path) {
            Ok(_) if is_new => fresh.push(path),
            Ok(_) => {}
            Err(e) => {
                for path in fresh {
                    let _ = fs::remove_file(path);
                }
                return Err(failed(&path, e.error));
            }
        }
    }
    Ok(())
}

fn failed(path: &Path, cause: io::Error) -> DeliveryError {
    DeliveryError {
        path: path.to_owned(),
        cause,
    }
}

fn target(path: &Path) -> io::Result<Target> {
    let path = match fs::metadata(path) {
        Ok(there) if there.is_dir() => {
            return Err(io::Error::new(
                io::ErrorKind::IsADirectory,
                "it is a folder",
            ));
        }
        Ok(there) if !there.is_file() => return Ok(Target::Device(path.to_owned())),
        Ok(there) if there.permissions().readonly() => {
            return Err(io::Error::new(
                io::ErrorKind::PermissionDenied,
                "the file that is there is write-protected",
            ));
        }
        // A rename would replace a link instead of what it points to.
        Ok(_) => path.canonicalize()?,
        Err(e) if e.kind() == io::ErrorKind::NotFound => path.to_owned(),
        Err(e) => return Err(e),
    };
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    };
    match fs::metadata(&folder) {
        Ok(there) if there.is_dir() => Ok(Target::File { path, folder }),
        Ok(_) => Err(io::Error::new(
            io::ErrorKind::NotADirectory,
            format!("{} is not a folder", folder.display()),
        )),
        Err(e) => Err(io::Error::new(
            e.kind(),
            format!("folder {}: {e}", folder.display()),
        )),
    }
}

fn stage(folder: &Path, bytes: &[u8]) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".midshell-").suffix(".tmp");
    // A temporary file is private by default; a result is as open as the user's mask allows.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    // A full disk may show only when the bytes are really put down.
    file.as_file().sync_all()?;
    Ok(file)
}

fn write_straight(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = fs::OpenOptions::new().write(true).open(path)?;
    file.write_all(bytes)?;
    file.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn all_files_are_written_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("b"), "old").unwrap();
        deliver(&[(at("a"), b"one".to_vec()), (at("b"), b"two".to_vec())]).unwrap();
        assert_eq!(fs::read(at("a")).unwrap(), b"one");
        assert_eq!(fs::read(at("b")).unwrap(), b"two");
        assert_eq!(names(folder.path()), ["a", "b"]);
    }

    #[test]
    fn a_full_disk_leaves_nothing_and_keeps_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let old = folder.path().join("old.vtu");
        fs::write(&old, "old").unwrap();
        let new = folder.path().join("new.vtu");
        let outputs = [
            (old.clone(), b"x".to_vec()),
            (new, b"x".to_vec()),
            (PathBuf::from("/dev/full"), b"x".to_vec()),
        ];
        let error = deliver(&outputs).unwrap_err();
        assert_eq!(error.cause.kind(), io::ErrorKind::StorageFull);
        assert_eq!(error.path, Path::new("/dev/full"));
        assert_eq!(names(folder.path()), ["old.vtu"]);
        assert_eq!(fs::read(&old).unwrap(), b"old");
    }

    #[test]
    fn a_rename_that_fails_takes_back_the_files_before_it() {
        let folder = tempfile::tempdir().unwrap();
        let (first, second) = (folder.path().join("first"), folder.path().join("second"));
        let staged = [&first, &second].map(|p| (p.clone(), stage(folder.path(), b"x").unwrap()));
        // Between staging and renaming somebody makes a folder of that name.
        fs::create_dir(&second).unwrap();
        let error = publish(staged.into()).unwrap_err();
        assert_eq!(error.path, second);
        assert_eq!(names(folder.path()), ["second"]);
    }

    #[test]
    fn the_probe_refuses_what_cannot_be_written_and_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(probe(&folder.path().join("fine")).is_ok());
        for bad in [
            folder.path().to_owned(),
            folder.path().join("missing/out"),
            file.join("out"),
            PathBuf::from("/proc/midshell.vtu"),
        ] {
            assert!(probe(&bad).is_err(), "{}", bad.display());
        }
        assert_eq!(names(folder.path()), ["file"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_write_protection_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        deliver(&[(link.clone(), b"new".to_vec())]).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());

        let mut mode = fs::metadata(&file).unwrap().permissions();
        mode.set_readonly(true);
        fs::set_permissions(&file, mode).unwrap();
        let error = deliver(&[(file.clone(), b"newer".to_vec())]).unwrap_err();
        assert_eq!(error.cause.kind(), io::ErrorKind::PermissionDenied);
        assert_eq!(fs::read(&file).unwrap(), b"new");
    }

    #[cfg(unix)]
    #[test]
    fn results_are_as_open_as_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (plain, ours) = (folder.path().join("plain"), folder.path().join("ours"));
        fs::write(&plain, "").unwrap();
        deliver(&[(ours.clone(), Vec::new())]).unwrap();
        let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
