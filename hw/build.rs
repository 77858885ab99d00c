//! Says which RTL tools are here, so that a test that needs one is skipped visibly where it is missing and nowhere else.
//!
//! `RTL=require` says that all are, so that the tests run and fail instead.

use std::{env, process::Command};

/// Tool, its variable, how it tells its version.
const TOOLS: [(&str, &str, &str); 3] =
    [("verilator", "VERILATOR", "--version"), ("iverilog", "IVERILOG", "-V"), ("yosys", "YOSYS", "-V")];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=RTL");
    println!("cargo::rerun-if-env-changed=PATH");
    let required = env::var_os("RTL").is_some_and(|value| value == "require");
    for (tool, variable, version) in TOOLS {
        println!("cargo::rerun-if-env-changed={variable}");
        println!("cargo::rustc-check-cfg=cfg({tool})");
        let program = env::var(variable).unwrap_or_else(|_| tool.into());
        let found = Command::new(program).arg(version).output().is_ok_and(|output| !output.stdout.is_empty());
        if found || required {
            println!("cargo::rustc-cfg={tool}");
        } else {
            println!("cargo::warning={tool} is not installed: its RTL tests are skipped (apt-get install {tool})");
            // A file that is never there: look again at the next build, so that a later install is noticed.
            println!("cargo::rerun-if-changed=no-such-file");
        }
    }
}
