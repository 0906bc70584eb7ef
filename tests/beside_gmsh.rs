//! What `tools/quads_beside_gmsh.py` gives to Gmsh and how it judges: the script's own checks, on mid-surfaces made by hand.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[allow(dead_code)]
#[path = "common/tools.rs"]
mod tools;

use std::time::Duration;

#[test]
fn the_comparison_with_gmsh_is_sound() {
    let command = tools::python("check_quads_beside_gmsh.py");
    tools::run(command, Duration::from_secs(300));
}
