//! Errors in TOML files, shown the way rustc shows them: the line, the value underlined, and a remedy.

use std::{ops::Range, path::Path};

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

use crate::error::Error;

/// Something wrong with the bytes `span` of `source`, the text of `path`. `label` stands beside the underlined value.
#[must_use]
pub fn error(
    path: &Path,
    source: &str,
    span: Range<usize>,
    problem: impl Into<String>,
    label: impl Into<String>,
    remedy: impl Into<String>,
) -> Error {
    // A span of a whole table would underline the file: its first line says enough.
    let start = span.start.min(source.len());
    let line_end = source[start..].find('\n').map_or(source.len(), |length| start + length);
    let end = span.end.clamp(start, line_end);
    let snippet = Snippet::source(source)
        .path(path.display().to_string())
        .annotation(AnnotationKind::Primary.span(start..end).label(label.into()));
    let group = Level::ERROR
        .no_name()
        .primary_title(problem.into())
        .element(snippet)
        .element(Level::HELP.message(remedy.into()));
    Error::Rendered(Renderer::plain().render(&[group]).trim_start_matches([':', ' ']).to_owned())
}

/// What the TOML parser or serde found: a syntax error, an unknown key, a value of the wrong type.
#[must_use]
pub fn toml_error(path: &Path, source: &str, found: &toml::de::Error, remedy: impl Into<String>) -> Error {
    let mut lines = found.message().lines();
    let problem = lines.next().unwrap_or("not TOML").to_owned();
    let label = lines.collect::<Vec<_>>().join("; ");
    error(path, source, found.span().unwrap_or(0..0), problem, label, remedy)
}
