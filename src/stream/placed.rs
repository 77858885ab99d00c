//! One address space for many textures: each begins where the one before ends.

use texunit_hw::{
    Footprint,
    address_stream::{AddressBatch, Sink},
    batch::Batch,
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
    fn take(&mut self, batch: AddressBatch<'_>) {
        self.taps.clear();
        self.taps.extend((0..batch.taps()).map(|number| {
            let (plane, addresses) = batch.tap(number);
            Footprint {
                // What is outside stays outside: its mark is far above any base.
                address: addresses.map(|address| address + self.base),
                plane: plane as u16 + self.first_plane,
                ..Footprint::default()
            }
        }));
        let AddressBatch { requests, texels_per_tap, surface, .. } = batch;
        self.inner.take(Batch { taps: self.taps, requests, texels_per_tap, surface }.into());
    }
}
