//! The laws of ARCHITECTURE.md, read off the sources: who may name whom, which foreign crate stays behind which file, what a stage may not touch.
//!
//! Only what is built into the product is looked at: `#[cfg(test)]` modules may name what they need. Every law has a test in which a planted
//! violation is found.

#![allow(clippy::unwrap_used)]

mod laws;

use laws::{Source, violations};
use std::path::{Path, PathBuf};

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

#[test]
fn the_sources_keep_the_laws() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files: Vec<PathBuf> = ["src", "tests"]
        .iter()
        .flat_map(|folder| sources(&root.join(folder)))
        .collect();
    assert!(files.len() > 10, "the sources were not found");
    let found: Vec<String> = files
        .iter()
        .flat_map(|file| {
            let name = file
                .strip_prefix(root)
                .unwrap()
                .to_string_lossy()
                .replace('\\', "/");
            let text = std::fs::read_to_string(file).unwrap();
            violations(&Source {
                name: &name,
                text: &text,
            })
        })
        .collect();
    assert!(found.is_empty(), "\n{}\n", found.join("\n"));
}

/// How many violations a planted file has.
fn planted(name: &str, text: &str) -> Vec<String> {
    violations(&Source { name, text })
}

#[track_caller]
fn caught(name: &str, text: &str) {
    assert_eq!(
        planted(name, text).len(),
        1,
        "{name}: {text}: {:?}",
        planted(name, text)
    );
}

#[track_caller]
fn lawful(name: &str, text: &str) {
    assert_eq!(planted(name, text), Vec::<String>::new(), "{name}: {text}");
}

#[test]
fn the_model_depends_on_nothing_but_itself() {
    caught("src/model/brep.rs", "use crate::geom::placer::Placer;");
    caught("src/model/brep.rs", "use super::super::geom::Placer;");
    lawful(
        "src/model/brep.rs",
        "use super::ids::{FaceId, Id};\nuse crate::model::tets::Tets;",
    );
}

#[test]
fn shared_mathematics_knows_no_stage() {
    caught(
        "src/geom/placer.rs",
        "fn f() { crate::stage::pair::pair() }",
    );
    caught("src/spatial.rs", "use crate::import::gmsh;");
    lawful(
        "src/geom/placer.rs",
        "use crate::model::ids::FaceId;\nuse super::triangle::area;",
    );
}

#[test]
fn a_stage_never_names_another_stage_nor_what_is_above_it() {
    caught("src/stage/pair.rs", "use super::role::Role;");
    caught(
        "src/stage/pair.rs",
        "use crate::stage::{pair::Gate, role::Role};",
    );
    caught("src/stage/pair/gates.rs", "use super::super::role::Role;");
    for upper in ["import", "export", "pipeline", "cli", "doctor"] {
        caught("src/stage/pair.rs", &format!("use crate::{upper}::x;"));
    }
    lawful(
        "src/stage/pair.rs",
        "use crate::{model::{brep::Brep, ids}, geom::placer, spatial::Bvh};",
    );
    lawful(
        "src/stage/pair/gates.rs",
        "use super::widths::Width;\nuse crate::stage::pair::Gate;",
    );
    lawful(
        "src/stage/pair/mod.rs",
        "use self::gates::Gate;\nmod gates;",
    );
}

#[test]
fn the_command_line_knows_only_the_front_of_the_library() {
    caught("src/cli/commands.rs", "use midshell::stage::pair;");
    caught("src/main.rs", "fn main() { midshell::import::read(); }");
    lawful(
        "src/cli/commands.rs",
        "use super::args::Cli;\nuse midshell::pipeline;",
    );
}

#[test]
fn foreign_crates_stay_behind_their_module() {
    for (foreign, home) in [
        ("obvhs", "spatial"),
        ("spade", "geom/cdt"),
        ("faer", "solve"),
        ("nix", "pipeline/memory"),
        ("flate2", "read/vtu_array"),
        ("toml", "toml_text"),
    ] {
        let text = format!("use {foreign}::Thing;");
        caught("src/geom/placer.rs", &text);
        lawful(&format!("src/{home}.rs"), &text);
    }
    caught("src/pipeline.rs", "fn f(d: &wgpu::Device) {}");
    lawful("src/gpu/device.rs", "use wgpu::Device;");
    lawful(
        "src/geom/placer.rs",
        "// spade::Thing is not used here\nconst A: &str = \"spade::Thing\";",
    );
}

#[test]
fn a_stage_touches_neither_files_nor_processes_nor_clocks_nor_streams() {
    for text in [
        "use std::fs::File;",
        "use std::{fmt, env};",
        "fn f() { std::process::exit(1) }",
        "use std::time::Instant;",
        "fn f() { println!(\"x\") }",
        "fn f() { eprintln!(\"x\") }",
        "fn f() { dbg!(1); }",
    ] {
        caught("src/stage/pair.rs", text);
    }
    lawful(
        "src/stage/pair.rs",
        "use std::{cmp, fmt};\nfn f() { writeln_all() }",
    );
    caught("src/export/vtu.rs", "use std::process::Command;");
    lawful("src/import/gmsh.rs", "use std::process::Command;");
}

#[test]
fn hash_order_needs_a_reason() {
    let import = "use std::collections::HashMap;";
    caught("src/stage/pair.rs", import);
    caught(
        "src/geom/placer.rs",
        "fn f() -> std::collections::HashSet<u32> { todo() }",
    );
    caught("src/stage/pair.rs", &format!("// unordered:\n{import}"));
    lawful(
        "src/stage/pair.rs",
        &format!("// unordered: only looked up, never walked\n{import}"),
    );
    lawful("src/stage/pair.rs", "use std::collections::BTreeMap;");
}

#[test]
fn test_modules_are_free_and_what_follows_them_is_not() {
    let tests = "#[cfg(test)]\nmod tests {\n    use crate::import::gmsh;\n    fn f() { let s = \"}\"; }\n}\n";
    lawful("src/stage/pair.rs", tests);
    caught(
        "src/stage/pair.rs",
        &format!("{tests}use crate::import::gmsh;"),
    );
}

#[test]
fn files_of_tests_are_free_and_declared_as_such() {
    lawful("src/stage/pair/tests.rs", "use crate::stage::role::Role;");
    lawful("src/test_parts.rs", "use crate::pipeline;");
    lawful(
        "src/stage/pair.rs",
        "#[cfg(test)]\nmod tests;\n#[cfg(test)]\npub(crate) mod test_shapes;",
    );
    lawful(
        "src/stage/pair.rs",
        "#[cfg(test)]\n#[path = \"pair_tests.rs\"]\nmod tests;",
    );
    lawful("src/stage/pair_tests.rs", "use crate::pipeline;");
    caught("src/stage/pair.rs", "mod tests;");
    caught("src/lib.rs", "pub mod test_parts;");
}

#[test]
fn files_stay_short_and_modules_have_a_law() {
    caught("src/geom/placer.rs", &"\n".repeat(601));
    lawful("src/geom/placer.rs", &"\n".repeat(600));
    caught("src/novelty.rs", "");
}
