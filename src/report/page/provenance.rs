//! Where a figure is from.

use maud::{Markup, html};
use serde_json::Value;

pub(super) fn pretty(value: &Value) -> String {
    toml::to_string(value).unwrap_or_else(|_| format!("{value:#}"))
}

/// The command that made a figure, and its machine with every default filled in.
pub(super) fn provenance(results: &Value) -> Markup {
    html! {
        details { summary { "Command and machine" } pre { (command(results)) "\n\n" (pretty(&results["machine"])) } }
    }
}

/// The command that made a figure, as one would type it.
pub(super) fn command(results: &Value) -> String {
    let words = results["command"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let command: Vec<String> = words
        .enumerate()
        .map(|(place, word)| match word.rsplit('/').next() {
            Some(program) if place == 0 => program.to_owned(),
            _ if word.chars().any(|letter| !letter.is_ascii_alphanumeric() && !"-_./=,:".contains(letter)) => {
                format!("'{}'", word.replace('\'', r"'\''"))
            }
            _ => word.to_owned(),
        })
        .collect();
    command.join(" ")
}
