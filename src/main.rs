//! The `texunit` command.

fn main() -> std::process::ExitCode {
    texunit::cli::main()
}
