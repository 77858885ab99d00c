//! One address space for many textures: each begins where the one before ends.

use texunit_hw::{
    Footprint,
    batch::{Batch, Sink},
};

/// Shows `inner` the taps of a texture as they are where it lies.
#[derive(Debug)]
pub struct Placed<'s, S> {
    /// Who looks.
    pub inner: &'s mut S,
    /// Byte address of the texture.
    pub base: u64,
    /// Number of its first plane among those of all textures.
    pub first_plane: u16,
    /// Where the moved taps are kept.
    pub taps: &'s mut Vec<Footprint>,
}

impl<S: Sink> Sink for Placed<'_, S> {
    fn take(&mut self, batch: Batch<'_>) {
        self.taps.clear();
        self.taps.extend(batch.taps.iter().map(|tap| Footprint {
            // What is outside stays outside: its mark is far above any base.
            address: tap.address.map(|address| address + self.base),
            plane: tap.plane + self.first_plane,
            ..*tap
        }));
        self.inner.take(Batch { taps: self.taps, ..batch });
    }
}
