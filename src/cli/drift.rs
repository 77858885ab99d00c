//! `texunit drift`: how rounding darkens or brightens a pyramid.

use std::{path::PathBuf, process::ExitCode};

use crate::{
    error::Result,
    pyramid::{
        PlaneImage,
        drift::{Averaging, Channel},
    },
    report::table::plain,
    scene::{Pattern, Procedural},
    texture_file,
};

/// Measure the drift of each rounding rule, and Flavell's darkening with and without compensation
///
/// Every rule halves an image level by level in channels of 8, 6 and 5 bits: noise, the fur
/// texture of the built-in scenes, its window panes (flat areas), and an image of yours. Shown is how far the mean of the last level
/// lies from that of the texture, in per cent of full scale (and, for one level, what uniform low bits lead to expect, in
/// steps of the channel).
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Measure this image too (its green channel, the largest power-of-two square from the upper left)
    image: Option<PathBuf>,
    /// Levels below the texture
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u8).range(1..=20))]
    levels: u8,
}

/// Side of the built-in images.
const SIDE: u32 = 512;

/// Channel depths: RGBA8, and the two of RGB565.
const DEPTHS: [u8; 3] = [8, 6, 5];

fn procedural(pattern: Pattern) -> PlaneImage {
    let texture = Procedural { pattern, size: [SIDE; 2], cell: 64, line: 6, seed: 1 };
    PlaneImage::of_image(&texture.image())
}

/// Runs the command.
///
/// # Errors
/// An unreadable image.
pub fn run(args: Args) -> Result<ExitCode> {
    let mut images = vec![("natural", procedural(Pattern::Natural)), ("pane", procedural(Pattern::Pane))];
    if let Some(path) = &args.image {
        images.push(("image", texture_file::load(path)?.top));
    }
    let mut columns: Vec<(String, Channel)> = Vec::new();
    for bits in DEPTHS {
        columns.push((format!("random {bits} bit"), Channel::random(SIDE as usize, bits, 1)));
        for (name, image) in &images {
            columns.push((format!("{name} {bits} bit"), Channel::of_image(image, bits)));
        }
    }
    let names = columns.iter().map(|(name, _)| name.clone());
    let mut table = plain(["rounding", "expected a level"].map(String::from).into_iter().chain(names), 1..);
    for averaging in Averaging::ALL {
        let measured = columns.iter().map(|(_, channel)| {
            let drift = channel.drift(averaging, args.levels).last().copied().unwrap_or(0.0);
            format!("{:+.2}", 100.0 * drift / f64::from((1u32 << channel.bits) - 1))
        });
        let expected = format!("{:+.3}", averaging.expected_drift());
        table.add_row([averaging.name().to_string(), expected].into_iter().chain(measured));
    }
    say!("Drift of the mean after {} levels, per cent of full scale; expected: steps of the channel.", args.levels);
    say!("{table}");
    Ok(ExitCode::SUCCESS)
}
