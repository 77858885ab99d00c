//! 256 colours for a texture, and the nearest of them (numerics-input E17: colours are averaged, never indices).

use rayon::prelude::*;
use texunit_hw::Palette;

use crate::pyramid::Pyramid;

/// A colour and how many texels have it.
type Counted = ([u8; 4], u64);

/// The colours of a texture if it has no more than 256, in rising order of (red, green, blue, alpha), followed by as many more as
/// there is room for from the colours of its smaller planes; otherwise 256 for the texture itself. What has to be chosen is chosen by
/// a median cut (Heckbert 1982).
///
/// The box with the largest product of longest side and texels is cut across that side, where half of its texels are on either
/// hand, until there are enough; each gives the mean of its texels, rounded half up. Of equals the first box and the first channel.
/// Places left over repeat the last colour.
#[must_use]
pub fn of_pyramid(pyramid: &Pyramid) -> Palette {
    let mut colours = counted(pyramid.planes[0].texels.clone());
    let entries: Vec<[u8; 4]> = if colours.len() > 256 {
        median_cut(&mut colours, 256)
    } else {
        let own: Vec<[u8; 4]> = colours.iter().map(|&(colour, _)| colour).collect();
        let others = pyramid.planes[1..].iter().flat_map(|plane| &plane.texels).copied();
        let mut others = counted(others.filter(|texel| own.binary_search(texel).is_err()).collect());
        let more = median_cut(&mut others, 256 - own.len());
        own.into_iter().chain(more).collect()
    };
    let last = *entries.last().unwrap_or(&[0; 4]);
    std::array::from_fn(|number| entries.get(number).copied().unwrap_or(last))
}

fn counted(mut texels: Vec<[u8; 4]>) -> Vec<Counted> {
    texels.par_sort_unstable();
    texels.chunk_by(|a, b| a == b).map(|equal| (equal[0], equal.len() as u64)).collect()
}

/// The nearest colour by squared distance over all four channels; the lowest index of several.
#[must_use]
pub fn nearest(palette: &Palette, texel: [u8; 4]) -> u8 {
    let mut best = (u32::MAX, 0u8);
    for (number, colour) in (0..=255).zip(palette) {
        let mut distance = 0;
        for channel in 0..4 {
            let apart = u32::from(colour[channel].abs_diff(texel[channel]));
            distance += apart * apart;
        }
        if distance < best.0 {
            best = (distance, number);
        }
    }
    best.1
}

/// Colours in a box, with the channel of its longest side and what the next cut goes by.
struct Section<'c> {
    colours: &'c mut [Counted],
    channel: usize,
    urgency: u64,
}

impl<'c> Section<'c> {
    fn new(colours: &'c mut [Counted]) -> Self {
        let mut longest = (0, 0);
        for channel in 0..4 {
            let values = || colours.iter().map(|(colour, _)| colour[channel]);
            let side = values().max().unwrap_or(0) - values().min().unwrap_or(0);
            if side > longest.0 {
                longest = (side, channel);
            }
        }
        let texels: u64 = colours.iter().map(|(_, count)| count).sum();
        Self { urgency: u64::from(longest.0) * texels, channel: longest.1, colours }
    }

    fn cut(self) -> [Self; 2] {
        let channel = self.channel;
        self.colours.par_sort_unstable_by_key(|&(colour, _)| (colour[channel], colour));
        let texels: u64 = self.colours.iter().map(|(_, count)| count).sum();
        let mut before = 0;
        let at = self.colours.iter().position(|(_, count)| {
            before += count;
            2 * before >= texels
        });
        let at = (at.unwrap_or(0) + 1).clamp(1, self.colours.len() - 1);
        let (low, high) = self.colours.split_at_mut(at);
        [Section::new(low), Section::new(high)]
    }

    fn mean(&self) -> [u8; 4] {
        let texels: u64 = self.colours.iter().map(|(_, count)| count).sum();
        std::array::from_fn(|channel| {
            let sum: u64 = self.colours.iter().map(|(colour, count)| u64::from(colour[channel]) * count).sum();
            ((2 * sum + texels) / (2 * texels)) as u8
        })
    }
}

/// At most `entries` colours for these; they themselves if they are no more.
fn median_cut(colours: &mut [Counted], entries: usize) -> Vec<[u8; 4]> {
    if colours.len() <= entries {
        return colours.iter().map(|&(colour, _)| colour).collect();
    }
    if entries == 0 {
        return Vec::new();
    }
    let mut sections = vec![Section::new(colours)];
    while sections.len() < entries {
        let urgent = (0..sections.len()).rev().max_by_key(|&number| sections[number].urgency).unwrap_or(0);
        let [low, high] = sections.swap_remove(urgent).cut();
        sections.push(low);
        sections.push(high);
    }
    sections.iter().map(Section::mean).collect()
}
