//! Writing a trace.

use std::io::{Error, Result, Write};

use super::{FIELDS, Profile, Trace, UNIT, VERSION, WITHOUT_EFFECT};

impl Trace {
    /// Writes the trace as docs/trace-format.md says.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write(&self, out: &mut dyn Write) -> Result<()> {
        writeln!(out, "// texunit trace {VERSION}")?;
        writeln!(out, "// unit {UNIT}")?;
        writeln!(out, "// model {}", self.model)?;
        write_profile(&self.profile, out)?;
        writeln!(out, "// seed {}", self.seed)?;
        writeln!(out, "// fields {}", fields_line())?;
        writeln!(out, "// count {}", self.records.len())?;
        self.records.iter().try_for_each(|record| writeln!(out, "{record}"))
    }
}

/// The lines of a head that say everything an answer depends on beside the request.
pub(super) fn write_profile(profile: &Profile, out: &mut dyn Write) -> Result<()> {
    let mut profile = toml::Table::try_from(profile).map_err(Error::other)?;
    if let Some(machine) = profile.get_mut("machine").and_then(toml::Value::as_table_mut) {
        machine.retain(|section, _| !WITHOUT_EFFECT.contains(&section));
    }
    assignments(&profile).into_iter().try_for_each(|(key, value)| writeln!(out, "// {key} = {value}"))
}

/// Names and widths of the fields, as the head says them.
pub(super) fn fields_line() -> String {
    FIELDS.map(|(name, width)| format!("{name}:{width}")).join(" ")
}

/// Every value of a table with its dotted key, each on a line of its own.
fn assignments(table: &toml::Table) -> Vec<(String, String)> {
    table
        .iter()
        .flat_map(|(key, value)| match value {
            toml::Value::Table(inner) => {
                assignments(inner).into_iter().map(|(below, value)| (format!("{key}.{below}"), value)).collect()
            }
            value => vec![(key.clone(), one_line(value))],
        })
        .collect()
}

/// A value without a line break in it: a JSON string is a TOML string, but for one character.
fn one_line(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => serde_json::Value::from(text.as_str()).to_string().replace('\u{7F}', "\\u007F"),
        toml::Value::Array(values) => format!("[{}]", values.iter().map(one_line).collect::<Vec<_>>().join(", ")),
        value => value.to_string(),
    }
}
