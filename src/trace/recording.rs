//! Making a trace from a scene.

use texunit_hw::Request;

use super::{Player, Profile, Trace};
use crate::{error::Result, experiment::verify::SplitMix, scene::Scene, texture_file::TextureImage};

/// Which fragments of a scene become requests; they keep the scene's order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Selection {
    /// All of them.
    #[default]
    All,
    /// So many: one, at random, from each of as many stretches of equal length, so that no pattern of the scene's rows is met.
    /// All of them where there are no more.
    Count(u64),
    /// Every so many-th, from the first.
    Every(u64),
}

impl Selection {
    /// Calls `visit` with the requests of the fragments selected, block by block.
    ///
    /// # Errors
    /// Those of `visit`, at the first.
    pub fn requests(
        self,
        scene: &Scene,
        profile: &Profile,
        seed: u64,
        mut visit: impl FnMut(&[Request]) -> Result<()>,
    ) -> Result<()> {
        let covered = if matches!(self, Self::Count(_)) { scene.coverage().covered } else { 0 };
        let front_end = profile.front_end().of_shape(&profile.machine, |seen| {
            scene.for_each_block(|fragments| seen.add(fragments));
        });
        let mut numbers = self.numbers(covered, seed);
        let mut next = numbers.next();
        let mut first = 0;
        let mut blocks = scene.blocks();
        let mut requests = Vec::new();
        while let Some(fragments) = blocks.next_block() {
            let end = first + fragments.len() as u64;
            while let Some(number) = next.filter(|&number| number < end) {
                requests.push(front_end.request(&fragments[(number - first) as usize]).0);
                next = numbers.next();
            }
            first = end;
            visit(&requests)?;
            requests.clear();
        }
        Ok(())
    }

    /// The numbers of the fragments, rising.
    fn numbers(self, covered: u64, seed: u64) -> Box<dyn Iterator<Item = u64>> {
        match self {
            Self::Count(count) if count < covered => {
                let mut random = SplitMix(seed);
                // Products of two numbers below 2^32 each: a scene has at most 2^28 pixels.
                Box::new((0..count).map(move |number| {
                    let [begin, end] = [number, number + 1].map(|number| number * covered / count);
                    begin + random.draw() % (end - begin)
                }))
            }
            Self::All | Self::Count(_) => Box::new(0..),
            Self::Every(step) => Box::new((0..).step_by(usize::try_from(step).unwrap_or(usize::MAX).max(1))),
        }
    }
}

/// Records what the chip answers to requests of a scene with this texture.
///
/// # Errors
/// A machine that cannot be built.
pub fn record(
    scene: &Scene,
    texture: &TextureImage,
    profile: Profile,
    selection: Selection,
    seed: u64,
) -> Result<Trace> {
    let mut requests = Vec::new();
    selection.requests(scene, &profile, seed, |block| {
        requests.extend_from_slice(block);
        Ok(())
    })?;
    let player = Player::with_texture(&profile, texture)?;
    let records = player.chip(&requests)?;
    Ok(Trace { profile, seed, model: env!("CARGO_PKG_VERSION").into(), records, lines: Vec::new() })
}
