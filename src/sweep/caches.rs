//! Many caches over one address stream, in as few passes as can be.

use texunit_hw::{
    Geometry, Policy,
    address_stream::{AddressBatch, Sink},
    cache::{Cache, GeometryError},
    sweep::{FifoSweep, Grid, LOG2_SETS_MAX, LruSweep, WAYS_MAX},
};

/// Addresses simulated at a time: few enough to stay in the second-level cache of the host.
const BLOCK: usize = 1 << 14;

/// Caches of one line size and one policy: those a grid holds in one pass, the others each in one of its own.
#[derive(Debug)]
pub struct Caches {
    geometries: Vec<Geometry>,
    one_pass: Option<OnePass>,
    alone: Vec<Cache>,
    addresses: Vec<u64>,
    lookups: u64,
}

#[derive(Debug)]
enum OnePass {
    Lru(LruSweep),
    Fifo(FifoSweep),
}

/// Whether a grid can hold it.
fn fits_grid(geometry: &Geometry) -> bool {
    geometry.sets.is_power_of_two()
        && geometry.sets <= 1 << LOG2_SETS_MAX
        && geometry.ways <= WAYS_MAX
        && geometry.line > 1
}

impl Caches {
    /// Empty caches of these shapes, all of the same line.
    ///
    /// # Errors
    /// What [`Geometry::check`] refuses.
    pub fn new(geometries: &[Geometry], policy: Policy) -> Result<Self, GeometryError> {
        geometries.iter().try_for_each(Geometry::check)?;
        let stack = matches!(policy, Policy::Lru | Policy::Fifo);
        let (together, alone): (Vec<Geometry>, Vec<Geometry>) =
            geometries.iter().partition(|geometry| stack && geometries.len() > 1 && fits_grid(geometry));
        let grid = together.first().map(|first| Grid {
            log2_sets: together.iter().map(|geometry| geometry.sets.trailing_zeros()).max().unwrap_or(0),
            ways: together.iter().map(|geometry| geometry.ways).max().unwrap_or(1),
            line: first.line,
        });
        let one_pass = match grid {
            None => None,
            Some(grid) if policy == Policy::Fifo => Some(OnePass::Fifo(FifoSweep::new(grid)?)),
            Some(grid) => Some(OnePass::Lru(LruSweep::new(grid)?)),
        };
        let alone = alone.into_iter().map(|geometry| Cache::new(geometry, policy)).collect::<Result<_, _>>()?;
        Ok(Self { geometries: geometries.to_vec(), one_pass, alone, addresses: Vec::with_capacity(BLOCK), lookups: 0 })
    }

    /// Simulates what was taken but not yet simulated.
    fn flush(&mut self) {
        self.lookups += self.addresses.len() as u64;
        match &mut self.one_pass {
            Some(OnePass::Lru(sweep)) => sweep.access_all(&self.addresses),
            Some(OnePass::Fifo(sweep)) => sweep.access_all(&self.addresses),
            None => {}
        }
        for cache in &mut self.alone {
            cache.access_all(&self.addresses, &mut ());
        }
        self.addresses.clear();
    }

    /// Lookups, and the misses of each cache in the order they were given.
    #[must_use]
    pub fn finish(mut self) -> (u64, Vec<(Geometry, u64)>) {
        self.flush();
        let misses = |geometry: &Geometry| {
            let alone = self.alone.iter().find(|cache| cache.geometry() == *geometry).map(Cache::misses);
            let together = || {
                let log2_sets = geometry.sets.trailing_zeros();
                match &self.one_pass {
                    Some(OnePass::Lru(sweep)) => sweep.misses(log2_sets, geometry.ways),
                    Some(OnePass::Fifo(sweep)) => sweep.misses(log2_sets, geometry.ways),
                    None => 0,
                }
            };
            alone.unwrap_or_else(together)
        };
        (self.lookups, self.geometries.iter().map(|geometry| (*geometry, misses(geometry))).collect())
    }
}

impl Sink for Caches {
    fn take(&mut self, batch: AddressBatch<'_>) {
        batch.for_each_read(|_, address| self.addresses.push(address));
        if self.addresses.len() >= BLOCK {
            self.flush();
        }
    }
}
