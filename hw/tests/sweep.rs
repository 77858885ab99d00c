//! Many caches at once against one cache at a time, and reuse distances against a search through a list.

use proptest::prelude::*;
use texunit_hw::{
    cache::{Cache, Policy},
    sweep::{Distances, FifoSweep, Grid, LineTable, LruSweep, ReuseDistances},
};

/// Addresses as texture units make them: runs, turns of two, walks and jumps.
fn addresses() -> impl Strategy<Value = Vec<u64>> {
    let step = prop_oneof![
        4 => (0..4_u64).prop_map(|back| (false, back)),
        2 => (0..40_u64).prop_map(|line| (true, line * 64)),
        2 => (0..4096_u64).prop_map(|address| (true, address * 37)),
        1 => any::<u16>().prop_map(|address| (true, u64::from(address) << 8)),
    ];
    proptest::collection::vec(step, 1..700).prop_map(|steps| {
        let mut addresses: Vec<u64> = vec![0];
        for (fresh, value) in steps {
            let address = if fresh { value } else { addresses[addresses.len().saturating_sub(1 + value as usize)] };
            addresses.push(address);
        }
        addresses
    })
}

fn alone(geometry: texunit_hw::Geometry, policy: Policy, addresses: &[u64]) -> u64 {
    let mut cache = Cache::new(geometry, policy).unwrap();
    cache.access_all(addresses, &mut ());
    cache.misses()
}

fn agrees(grid: Grid, addresses: &[u64], cut: usize) {
    let mut lru = LruSweep::new(grid).unwrap();
    let mut fifo = FifoSweep::new(grid).unwrap();
    let (first, second) = addresses.split_at(cut % (addresses.len() + 1));
    for part in [first, second] {
        lru.access_all(part);
        fifo.access_all(part);
    }
    assert_eq!([lru.lookups(), fifo.lookups()], [addresses.len() as u64; 2]);
    for geometry in grid.geometries() {
        let log2 = geometry.sets.trailing_zeros();
        assert_eq!(lru.misses(log2, geometry.ways), alone(geometry, Policy::Lru, addresses), "lru {geometry:?}");
        assert_eq!(fifo.misses(log2, geometry.ways), alone(geometry, Policy::Fifo, addresses), "fifo {geometry:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn one_pass_counts_what_176_runs_count(addresses in addresses(), cut in any::<usize>()) {
        agrees(Grid { log2_sets: 10, ways: 16, line: 64 }, &addresses, cut);
    }

    #[test]
    fn grids_of_any_size_agree_too(addresses in addresses(), cut in any::<usize>(), log2_sets in 0..6_u32, ways in 1..=16_u32, line in 1..9_u32) {
        agrees(Grid { log2_sets, ways, line: 1 << line }, &addresses, cut);
    }

    #[test]
    fn addresses_beyond_32_bits_of_lines_agree_too(mut addresses in addresses(), cut in any::<usize>(), at in any::<prop::sample::Index>()) {
        let late = at.index(addresses.len());
        addresses[late..].iter_mut().step_by(3).for_each(|address| *address |= 0xFFFF_F000_0000_0000);
        agrees(Grid { log2_sets: 3, ways: 16, line: 2 }, &addresses, cut);
    }

    #[test]
    fn reuse_distance_is_the_place_in_the_list_of_recent_lines(addresses in addresses()) {
        let mut reuse = ReuseDistances::default();
        let mut recent: Vec<u64> = Vec::new();
        let mut distances = Distances::default();
        for line in addresses.iter().map(|address| address >> 6) {
            let place = recent.iter().position(|&known| known == line);
            place.map(|place| recent.remove(place));
            recent.insert(0, line);
            let distance = reuse.lookup(line);
            prop_assert_eq!(distance, place.map(|place| place as u64));
            distances.count(distance);
        }
        prop_assert_eq!(reuse.lines(), recent.len() as u64);
        for lines in 1..40 {
            let geometry = texunit_hw::Geometry { sets: 1, ways: lines, line: 64 };
            prop_assert_eq!(distances.misses(lines.into()), alone(geometry, Policy::Lru, &addresses));
        }
    }
}

#[test]
fn reuse_distances_survive_the_renumbering_of_time() {
    let mut reuse = ReuseDistances::default();
    for round in 0..20_u64 {
        for line in 0..3000 {
            assert_eq!(reuse.lookup(line), (round > 0).then_some(2999));
        }
    }
}

#[test]
fn distances_beyond_the_exact_ones_are_counted_in_eighths_of_a_power_of_two() {
    let mut distances = Distances::default();
    for distance in [4095, 4096, 4607, 4608, 1 << 20, 1 << 40] {
        distances.count(Some(distance));
    }
    for (lines, misses) in
        [(4095, 6), (4096, 5), (4608, 3), (5120, 2), (1 << 20, 2), ((1 << 20) + (1 << 17), 1), (1 << 41, 0)]
    {
        assert_eq!(distances.misses(lines), misses, "{lines} lines");
    }
}

#[test]
fn a_curve_falls_to_the_first_references_and_ends_there() {
    let mut distances = Distances::default();
    (0..100).for_each(|distance| distances.count(Some(distance)));
    distances.count(None);
    let curve: Vec<_> = distances.curve().collect();
    assert_eq!(curve[..5], [(1, 100), (2, 99), (3, 98), (4, 97), (6, 95)]);
    assert_eq!(curve.last(), Some(&(128, 1)));
    assert_eq!(distances.working_set(100), 90);
    assert_eq!(distances.working_set(0), 100);
}

#[test]
fn lines_are_numbered_as_they_appear() {
    let mut table = LineTable::default();
    assert!(table.is_empty());
    let lines = [1 << 24, (1 << 24) - 1, 0, u64::MAX, 1 << 24];
    assert_eq!(lines.map(|line| table.number(line)), [0, 1, 2, 3, 0]);
}

#[test]
fn grids_that_are_too_large_are_refused_with_the_key() {
    for (grid, key) in [
        (Grid { log2_sets: 17, ways: 1, line: 64 }, "log2_sets"),
        (Grid { log2_sets: 0, ways: 0, line: 64 }, "ways"),
        (Grid { log2_sets: 0, ways: 17, line: 64 }, "ways"),
        (Grid { log2_sets: 0, ways: 1, line: 1 }, "line"),
        (Grid { log2_sets: 0, ways: 1, line: 48 }, "line"),
    ] {
        assert_eq!(LruSweep::new(grid).map(|_| ()).unwrap_err().key, key);
        assert_eq!(FifoSweep::new(grid).map(|_| ()).unwrap_err().key, key);
    }
}
