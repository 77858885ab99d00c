//! The page: results of other commands as one HTML file that needs nothing else.

mod figures;
mod provenance;
mod results;
mod run;
mod studies;

pub use results::{Images, Results};

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Looks: a column that fits a phone, light or dark as the reader's system is, ink on white when printed.
const STYLE: &str = include_str!("page/page.css");

/// The two hands of the image comparison, and the count of figures that are there (for the test).
const SCRIPT: &str = include_str!("page/page.js");

/// The page of some results.
#[must_use]
pub fn page(title: &str, results: &[Results]) -> String {
    let sections: Vec<(String, Markup)> =
        results.iter().enumerate().flat_map(|(number, results)| figures::sections(number, results)).collect();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                // No icon, and no request for one.
                link rel="icon" href="data:,";
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { (title) }
                    p.quiet { "texunit " (env!("CARGO_PKG_VERSION")) ". Errors are in LSB, the steps of an 8-bit channel, against supersampled ground truth." }
                }
                nav { ul { @for (number, (heading, _)) in sections.iter().enumerate() { li { a href={ "#s" (number) } { (heading) } } } } }
                main {
                    @for (number, (heading, section)) in sections.iter().enumerate() {
                        section id={ "s" (number) } { h2 { (heading) } (section) }
                    }
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}
