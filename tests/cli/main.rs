//! The commands run, sample, mips, scenes, time, trace, verify and explain as a user meets them: files, columns, exit status, and what is
//! said when something is wrong.

mod machine;
mod mips;
mod run;
mod sample;
mod scenes;
mod time;
mod trace;
mod verify;

use std::{
    path::Path,
    process::{Command, Output},
};

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_texunit"));
    command.current_dir(folder).args(arguments);
    command
}

fn texunit(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

#[track_caller]
fn good(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Bad use: exit status 2, nothing on standard output, and a message with all that helps.
#[track_caller]
fn refused(output: &Output, parts: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "", "{message}");
    for part in parts {
        assert!(message.contains(part), "no `{part}` in: {message}");
    }
}

#[test]
fn every_command_explains_itself() {
    let folder = tempfile::tempdir().unwrap();
    let list = good(&texunit(folder.path(), &["--help"]));
    let commands: Vec<&str> = list
        .split_once("Commands:\n")
        .unwrap()
        .1
        .lines()
        .map_while(|line| line.strip_prefix("  ")?.split_whitespace().next())
        .filter(|name| *name != "help")
        .collect();
    for name in ["run", "sample", "mips", "trace", "cache", "verify", "scenes", "explain"] {
        assert!(commands.contains(&name), "{name} in {list}");
    }
    let mut pages: Vec<Vec<&str>> = commands.iter().map(|name| vec![*name]).collect();
    pages.extend(["record", "replay", "verify", "export"].map(|action| vec!["trace", action]));
    for page in pages {
        let line = list.lines().find(|line| line.trim_start().starts_with(page[0])).unwrap();
        assert!(line.split_whitespace().count() > 3, "no word about {line}");
        let help = good(&texunit(folder.path(), &[page.as_slice(), &["--help"]].concat()));
        assert!(help.contains("Usage: texunit"), "{help}");
        // Every argument and option says what it is.
        let lines: Vec<&str> = help.lines().collect();
        for (number, line) in lines.iter().enumerate() {
            let option = line.trim_start();
            if line.starts_with("  ")
                && (option.starts_with("--") || option.starts_with('-') && !option.starts_with("- "))
            {
                let said = option.split("  ").count() > 1
                    || lines.get(number + 1).is_some_and(|next| next.starts_with("     "));
                assert!(said, "{page:?}: `{option}` says nothing");
            }
        }
    }
}

#[test]
fn no_command_or_an_unknown_one_is_bad_use() {
    let folder = tempfile::tempdir().unwrap();
    refused(&texunit(folder.path(), &[]), &["Usage: texunit", "run"]);
    refused(&texunit(folder.path(), &["render"]), &["render"]);
    assert!(good(&texunit(folder.path(), &["--version"])).contains(env!("CARGO_PKG_VERSION")));
}
