//! How much dearer than one cache are all? `cargo run --release -p texunit-hw --example sweep_speed`

mod floor;

use floor::{Contest, addresses};
use texunit_hw::{
    cache::{Cache, Geometry, Policy},
    sweep::{FifoSweep, Grid, LruSweep, ReuseDistances},
};

fn main() {
    let addresses = addresses();
    let (geometry, grid) = (Geometry { sets: 64, ways: 4, line: 64 }, Grid { log2_sets: 10, ways: 16, line: 64 });
    let run = |policy| {
        let mut cache = Cache::new(geometry, policy).unwrap();
        cache.access_all(&addresses, &mut ());
        cache.misses()
    };
    let mut contest = Contest { lookups: addresses.len(), entries: Vec::new() };
    contest.enter("64 x 4 lru", || run(Policy::Lru));
    contest.enter("176 lru", || {
        let mut sweep = LruSweep::new(grid).unwrap();
        sweep.access_all(&addresses);
        sweep.misses(6, 4)
    });
    contest.enter("64 x 4 fifo", || run(Policy::Fifo));
    contest.enter("176 fifo", || {
        let mut sweep = FifoSweep::new(grid).unwrap();
        sweep.access_all(&addresses);
        sweep.misses(6, 4)
    });
    contest.enter("reuse distances", || {
        let mut reuse = ReuseDistances::default();
        addresses.iter().filter_map(|address| reuse.lookup(address >> 6)).filter(|&distance| distance >= 256).count()
            as u64
            + reuse.lines()
    });
    contest.run(5);
    let [lru, all_lru, fifo, all_fifo, reuse] = [0, 1, 2, 3, 4].map(|entry| contest.entries[entry].seconds);
    println!(
        "176 lru cost {:.2} runs, 176 fifo {:.2} runs of fifo, {:.2} of lru",
        all_lru / lru,
        all_fifo / fifo,
        all_fifo / lru
    );
    println!("reuse distances cost {:.2} runs", reuse / lru);
}
