//! Child processes: make, and the programs it builds.

use std::{
    process::{Command, Output},
    sync::{Mutex, MutexGuard, PoisonError},
    thread,
};

use crate::repository;

/// One make at a time: they share a folder.
static MAKE: Mutex<()> = Mutex::new(());

/// Runs a target of hw/Makefile; the answer is its standard output.
pub fn make(target: &str) -> String {
    let _guard: MutexGuard<'_, ()> = MAKE.lock().unwrap_or_else(PoisonError::into_inner);
    let jobs = thread::available_parallelism().map_or(1, usize::from);
    let mut command = Command::new("make");
    command.arg("--no-print-directory").arg("-C").arg(repository().join("hw")).arg(format!("-j{jobs}")).arg(target);
    // Cargo's own make jobs are none of this make's.
    succeed(command.env_remove("MAKEFLAGS").env_remove("CARGO_MAKEFLAGS"))
}

/// Runs a program that make built, by its path below target/rtl.
pub fn program(path: &str, arguments: &[&str]) -> String {
    succeed(Command::new(repository().join("target/rtl").join(path)).args(arguments).current_dir(repository()))
}

fn succeed(command: &mut Command) -> String {
    let Output { status, stdout, stderr } = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let [stdout, stderr] = [stdout, stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    print!("{stdout}");
    assert!(status.success(), "{command:?}: {status}\n{stdout}\n{stderr}");
    stdout
}
