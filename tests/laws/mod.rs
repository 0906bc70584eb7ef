//! Reads the paths that a source file names and holds them against the laws.

mod scan;

use scan::{NamedPath, macros, modules, named_paths, product_code};

/// A source file: its name from the repository's root, with `/`.
pub struct Source<'a> {
    pub name: &'a str,
    pub text: &'a str,
}

/// Longest file, in lines.
const LONGEST: usize = 600;

/// What each top-level module of the library may name beside itself.
const MAY_NAME: &[(&str, &[&str])] = &[
    ("model", &[]),
    ("geom", &["model"]),
    ("spatial", &["model", "geom"]),
    ("solve", &["model", "geom"]),
    // What several stages ask for: the middle between the two sides of a wall.
    ("medial", &["model", "geom", "spatial"]),
    ("stage", &["model", "geom", "spatial", "solve", "medial"]),
    ("gpu", &["model", "geom", "spatial", "stage"]),
    // A fragment of the pipeline: it may call stages.
    ("charts", &["model", "geom", "spatial", "solve", "stage"]),
    ("options", &["model"]),
    ("exit_class", &[]),
    ("inspection", &["model"]),
    ("report_text", &["model"]),
    (
        "import",
        &["model", "geom", "spatial", "options", "exit_class"],
    ),
    ("export", &["model", "geom"]),
    // Readers of shell meshes; that of STL is import's.
    ("read", &["model", "import"]),
    ("toml_text", &[]),
    ("criteria", &["model", "toml_text"]),
    ("size_file", &["model", "toml_text"]),
    ("doctor", &["import", "options", "exit_class"]),
    (
        "pipeline",
        &[
            "charts",
            "model",
            "geom",
            "spatial",
            "solve",
            "stage",
            "gpu",
            "options",
            "exit_class",
            "inspection",
            "report_text",
            "medial",
            "import",
            "export",
            "read",
        ],
    ),
    // The binary: these are modules of the library.
    (
        "cli",
        &[
            "pipeline",
            "options",
            "exit_class",
            "inspection",
            "doctor",
            "export",
            "criteria",
            "size_file",
            "model",
        ],
    ),
];

/// Foreign crates and the one module, by its path, that may name each.
const FOREIGN_HOMES: [(&str, &str); 7] = [
    ("obvhs", "spatial"),
    ("spade", "geom::cdt"),
    ("faer", "solve"),
    ("wgpu", "gpu"),
    ("nix", "pipeline::memory"),
    ("flate2", "read::vtu_array"),
    ("toml", "toml_text"),
];

/// Parts of std that only some modules may name.
const STD_HOMES: [(&str, &[&str]); 4] = [
    ("fs", &["import", "export", "pipeline", "doctor", "cli"]),
    ("process", &["import", "doctor", "cli"]),
    ("time", &["import", "doctor", "pipeline", "options", "cli"]),
    ("env", &["import", "doctor", "cli"]),
];

/// Modules whose results must not hang on the order of a hash table.
const ORDERED: [&str; 5] = ["model", "geom", "spatial", "solve", "stage"];
/// The comment, on the line or the one above, that says why a hash table does no harm.
const ALLOW_UNORDERED: &str = "// unordered:";

/// Everything that is wrong with a file.
pub fn violations(source: &Source) -> Vec<String> {
    let mut found = Vec::new();
    let lines = source.text.lines().count();
    if lines > LONGEST {
        found.push(format!(
            "{}: {lines} lines, at most {LONGEST} are allowed",
            source.name
        ));
    }
    let Some(inside) = source.name.strip_prefix("src/") else {
        return found;
    };
    let module = module_path(inside);
    let code = product_code(source.text);
    for (name, line) in modules(&code).into_iter().filter(|m| is_test_module(&m.0)) {
        found.push(format!(
            "{}:{line}: module {name} lacks #[cfg(test)]",
            source.name
        ));
    }
    let Some(top) = module.first().cloned() else {
        return found;
    };
    if module.iter().any(|name| is_test_module(name)) {
        return found;
    }
    let Some((_, may_name)) = MAY_NAME.iter().find(|(name, _)| *name == top) else {
        found.push(format!(
            "{}: module {top} has no law: add it to tests/laws and ARCHITECTURE.md",
            source.name
        ));
        return found;
    };
    for path in named_paths(&code) {
        if let Some(why) = wrong_path(source, &module, may_name, &path) {
            found.push(format!("{}:{}: {why}", source.name, path.line));
        }
    }
    if top != "cli" {
        for (name, line) in macros(&code, &["print", "println", "eprint", "eprintln", "dbg"]) {
            found.push(format!(
                "{}:{line}: {name}! in the library: only the command line talks",
                source.name
            ));
        }
    }
    found
}

fn wrong_path(
    source: &Source,
    module: &[String],
    may_name: &[&str],
    path: &NamedPath,
) -> Option<String> {
    let top = module[0].as_str();
    let root = path.segments[0].as_str();
    match root {
        "crate" | "super" => {
            // A path inside the binary says `crate` of itself; all its modules are one.
            let full = absolute(module, &path.segments)?;
            if top == "cli" {
                return None;
            }
            wrong_arrow(module, may_name, &full)
        }
        "midshell" => wrong_arrow(module, may_name, &path.segments[1..]),
        "std" => {
            let part = path.segments.get(1)?.as_str();
            if let Some((_, homes)) = STD_HOMES.iter().find(|(name, _)| *name == part)
                && !homes.contains(&top)
            {
                return Some(format!("{top} names std::{part}"));
            }
            let hashed = path
                .segments
                .iter()
                .any(|s| s == "HashMap" || s == "HashSet");
            (hashed && ORDERED.contains(&top) && !excused(source.text, path.line))
                .then(|| format!("a hash table without '{ALLOW_UNORDERED} reason'"))
        }
        foreign => FOREIGN_HOMES
            .iter()
            .find(|(name, home)| *name == foreign && !is_within(module, home))
            .map(|(name, home)| format!("{top} names {name}, which stays behind {home}")),
    }
}

/// Whether a module is `home` or inside it.
fn is_within(module: &[String], home: &str) -> bool {
    let home: Vec<&str> = home.split("::").collect();
    module.len() >= home.len() && home.iter().zip(module).all(|(a, b)| a == b)
}

fn wrong_arrow(module: &[String], may_name: &[&str], named: &[String]) -> Option<String> {
    let target = named.first()?;
    if *target != module[0] {
        return (!may_name.contains(&target.as_str()))
            .then(|| format!("{} names {target}", module[0]));
    }
    // Within `stage` each stage stands alone; a file `stage/x.rs` and a folder `stage/x/` are one stage.
    if target == "stage"
        && let (Some(own), Some(other)) = (module.get(1), named.get(1))
        && own != other
    {
        return Some(format!("stage {own} names stage {other}"));
    }
    None
}

/// A module of this name is never built into the product: where it is declared, `#[cfg(test)]` must stand.
fn is_test_module(name: &str) -> bool {
    name == "tests" || name.starts_with("test_") || name.ends_with("_tests")
}

/// The module that a file is, from the crate's root: `stage/pair/mod.rs` is `[stage, pair]`. The binary's root counts as `cli`.
fn module_path(inside: &str) -> Vec<String> {
    match inside {
        "lib.rs" => return Vec::new(),
        "main.rs" => return vec!["cli".into()],
        _ => {}
    }
    let stem = inside.trim_end_matches(".rs").trim_end_matches("/mod");
    stem.split('/').map(str::to_owned).collect()
}

/// The path from the crate's root, without `crate`.
fn absolute(module: &[String], segments: &[String]) -> Option<Vec<String>> {
    if segments[0] == "crate" {
        return Some(segments[1..].to_vec());
    }
    let ups = segments.iter().take_while(|s| *s == "super").count();
    let base = module.len().checked_sub(ups)?;
    Some(
        module[..base]
            .iter()
            .chain(&segments[ups..])
            .cloned()
            .collect(),
    )
}

fn excused(text: &str, line: usize) -> bool {
    let lines: Vec<&str> = text.lines().collect();
    let above = line.checked_sub(2).and_then(|i| lines.get(i));
    let here = line.checked_sub(1).and_then(|i| lines.get(i));
    [above, here]
        .into_iter()
        .flatten()
        .filter_map(|l| l.split_once(ALLOW_UNORDERED))
        .any(|(_, reason)| !reason.trim().is_empty())
}
