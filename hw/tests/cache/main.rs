//! The cache against textbooks: a linear search through records that remember everything, and nothing clever.

mod textbook;

use std::collections::HashSet;

use proptest::prelude::*;
use texunit_hw::{
    Batch, Footprint, Format, Layout, PyramidKind, Requests, Sink, Surface,
    cache::{Cache, Detail, Geometry, LineSet, MissClassifier, Outcome, Policy, TexelCache},
};

use textbook::{Textbook, textbook_classes, textbook_use};

fn policies() -> impl Strategy<Value = Policy> {
    prop_oneof![
        Just(Policy::Lru),
        Just(Policy::Fifo),
        Just(Policy::Plru),
        any::<u64>().prop_map(|seed| Policy::Random { seed })
    ]
}

fn geometries() -> impl Strategy<Value = Geometry> {
    let ways = prop_oneof![1u32..=18, Just(24u32), Just(33), Just(64), Just(100), Just(256)];
    (prop_oneof![1u32..=9, Just(16u32), Just(64)], ways, 0u32..=12).prop_map(|(sets, ways, line)| Geometry {
        sets,
        ways,
        line: 1 << line,
    })
}

/// Addresses that stay near each other, leap, and come back; some at the far end of the 64-bit space.
fn addresses(geometry: Geometry) -> impl Strategy<Value = Vec<u64>> {
    let reach = geometry.size_bytes() * 2 + 3;
    let start = prop_oneof![Just(0u64), Just(u64::MAX - reach), Just(u64::MAX), any::<u64>()];
    let step = prop_oneof![
        6 => (0..u64::from(geometry.line) * 2).prop_map(|near| (false, near)),
        3 => (0..reach).prop_map(|far| (true, far)),
    ];
    (start, prop::collection::vec(step, 1..1500)).prop_map(move |(start, steps)| {
        let mut at = start;
        let walk = steps.into_iter().map(|(leap, by)| {
            at = if leap { start.wrapping_add(by) } else { at.wrapping_add(by) };
            at
        });
        walk.collect()
    })
}

fn cases() -> impl Strategy<Value = (Geometry, Policy, Vec<u64>)> {
    (geometries(), policies()).prop_flat_map(|(geometry, policy)| (Just(geometry), Just(policy), addresses(geometry)))
}

/// Caches that a request or two fill.
fn crowded() -> impl Strategy<Value = Geometry> {
    let line = prop::sample::select(vec![16, 32, 64]);
    (1_u32..4, 1_u32..5, line).prop_map(|(sets, ways, line)| Geometry { sets, ways, line })
}

/// A tap of four texels: where it is, how far right and down its neighbours are, its plane, and which texels are outside.
type TapPlan = (u64, u64, u64, u16, u8);

/// Requests that wander, and often stay where the one before was.
fn requests(taps: usize) -> impl Strategy<Value = Vec<Vec<TapPlan>>> {
    let step = prop::sample::select(vec![0, 4, 4, 4, 64, 256, 1024]);
    let outside = prop::sample::select(vec![0, 0, 0, 0, 0, 1, 5, 15]);
    let tap = (0_u64..512, step.clone(), step, 0_u16..3, outside);
    let fresh = prop::collection::vec(tap, taps);
    prop::collection::vec((fresh, prop::collection::vec(0_u64..3, taps), 0_u8..4), 1..60).prop_map(|drawn| {
        let mut requests: Vec<Vec<TapPlan>> = Vec::new();
        for (fresh, moves, choice) in drawn {
            let request = match requests.last() {
                // Three in four: as before, a texel or two further on.
                Some(before) if choice > 0 => before
                    .iter()
                    .zip(moves)
                    .map(|(&(at, right, down, plane, out), by)| (at + by, right, down, plane, out))
                    .collect(),
                _ => fresh,
            };
            requests.push(request);
        }
        requests
    })
}

/// What the addresses of a case's taps are made of: units look at eight taps at a time where all texels are inside, and all addresses
/// of 32 bits.
#[derive(Clone, Copy, Debug)]
enum Addresses {
    Inside,
    SomeOutside,
    /// Every other plane lies beyond 4 GiB, where addresses differ from others in the upper bits only.
    SomeFar,
}

fn footprint(&(at, right, down, plane, outside): &TapPlan, addresses: Addresses) -> Footprint {
    let (outside, base) = match addresses {
        Addresses::Inside => (0, 0),
        Addresses::SomeOutside => (outside, 0),
        Addresses::SomeFar => (0, u64::from(plane % 2) << 32),
    };
    let corners = [0, right, down, right + down].map(|step| base + 4 * at + step);
    let address = [0, 1, 2, 3].map(|i| if outside >> i & 1 == 1 { 1 << 62 } else { corners[i] });
    Footprint { address, plane, ..Footprint::default() }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn taps_in_batches_count_as_their_texels_one_by_one(
        geometry in prop_oneof![1 => geometries(), 3 => crowded()],
        policy in policies(),
        requests in (1_usize..6).prop_flat_map(requests),
        [classes, line_use] in any::<[bool; 2]>(),
        batch in 1_usize..40,
        as_ends in any::<bool>(),
        texels in prop::sample::select(vec![4, 4, 4, 1]),
        addresses in prop::sample::select(vec![Addresses::Inside, Addresses::Inside, Addresses::SomeOutside, Addresses::SomeFar]),
    ) {
        prop_assume!(geometry.line >= 4);
        let surface = Surface::new(PyramidKind::Mipmap, Layout::RowMajor, Format::Rgba8, 4, 4).unwrap();
        let mut one_by_one = TexelCache::new(geometry, policy, 4, Detail { classes, line_use }).unwrap();
        let mut batched = one_by_one.clone();
        for requests in requests.chunks(batch) {
            let taps: Vec<Footprint> = requests.iter().flatten().map(|plan| footprint(plan, addresses)).collect();
            for tap in &taps {
                for &address in tap.address[..texels].iter().filter(|address| **address < 1 << 62) {
                    one_by_one.read(tap.plane.into(), address);
                }
            }
            let each = requests[0].len();
            let ends: Vec<u32> = (1..=requests.len()).map(|request| (request * each) as u32).collect();
            let divided = if as_ends { Requests::Ends(&ends) } else { Requests::Each(each) };
            batched.take(Batch { taps: &taps, requests: divided, texels_per_tap: texels, surface: &surface }.into());
        }
        prop_assert_eq!(batched.counters(), one_by_one.counters());
        let (mut found, mut expected) = (batched.planes(), one_by_one.planes());
        found.resize(3, Default::default());
        expected.resize(3, Default::default());
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn every_policy_and_shape_agrees_with_the_textbook_on_every_lookup((geometry, policy, addresses) in cases()) {
        let mut textbook = Textbook::new(geometry, policy);
        let expected: Vec<Outcome> = addresses.iter().map(|&address| textbook.access(address)).collect();
        let mut one_by_one = Cache::new(geometry, policy).unwrap();
        for (&address, &outcome) in addresses.iter().zip(&expected) {
            prop_assert_eq!(one_by_one.access(address), outcome, "{:?} {:?} at {:#x}", geometry, policy, address);
        }
        // In whatever lanes, in blocks shorter and longer than those that lanes take at a time.
        let new = || Cache::new(geometry, policy).unwrap();
        let mut in_blocks = [new(), new().narrow_lanes(), new().scalar()];
        for cache in &mut in_blocks {
            let (short, long) = addresses.split_at(addresses.len() / 3);
            short.chunks(97).chain(long.chunks(601)).for_each(|block| cache.access_all(block, &mut ()));
        }
        let misses = expected.iter().filter(|outcome| !outcome.is_hit()).count() as u64;
        let evictions =
            expected.iter().filter(|outcome| matches!(outcome, Outcome::Miss { evicted: Some(_), .. })).count() as u64;
        for cache in in_blocks.iter().chain([&one_by_one]) {
            prop_assert_eq!(cache.lookups(), addresses.len() as u64);
            prop_assert_eq!(cache.misses(), misses);
            prop_assert_eq!(cache.evictions(), evictions);
        }
    }

    #[test]
    fn misses_fall_into_the_three_classes_as_defined((geometry, policy, addresses) in cases()) {
        let mut cache = Cache::new(geometry, policy).unwrap();
        let mut classifier = MissClassifier::new(geometry).unwrap();
        let (short, long) = addresses.split_at(addresses.len() / 3);
        short.chunks(97).chain(long.chunks(601)).for_each(|block| cache.access_all(block, &mut classifier));
        let classes = classifier.classes();
        let got = [classes.compulsory, classes.capacity, classes.conflict];
        prop_assert_eq!(got, textbook_classes(geometry, policy, &addresses), "{:?} {:?}", geometry, policy);
        prop_assert_eq!(got.iter().sum::<u64>(), cache.misses());
    }

    #[test]
    fn the_texel_cache_conserves_lookups_bytes_and_classes(
        (geometry, policy, addresses) in cases(),
        texel in 0u32..=4,
        planes in 1usize..5,
    ) {
        let texel = 1 << texel.min(geometry.line.trailing_zeros());
        let mut cache = TexelCache::new(geometry, policy, texel, Detail::default()).unwrap();
        let mut expected = vec![0; planes];
        for (number, block) in addresses.chunks(5).enumerate() {
            let plane = number * 7 % planes;
            expected[plane] += block.len() as u64;
            if number % 3 == 0 {
                block.iter().for_each(|&address| { cache.read(plane, address); });
            } else {
                cache.read_all(plane, block);
            }
        }
        let c = cache.counters();
        prop_assert_eq!(c.lookups, addresses.len() as u64);
        prop_assert_eq!(c.hits + c.misses, c.lookups);
        prop_assert_eq!(
            [c.compulsory, c.capacity, c.conflict],
            textbook_classes(geometry, policy, &addresses)
        );
        prop_assert_eq!(c.fills, c.misses);
        prop_assert_eq!(c.fills - c.evictions, cache.cache().resident());
        prop_assert_eq!(c.bytes_requested, c.lookups * u64::from(texel));
        prop_assert_eq!(c.bytes_fetched, c.fills * u64::from(geometry.line));
        prop_assert_eq!(c.bytes_used, textbook_use(geometry, policy, u64::from(texel), &addresses));
        prop_assert!(c.bytes_used <= c.bytes_fetched && c.bytes_used <= c.bytes_requested);
        let rows = cache.planes();
        for (plane, &lookups) in expected.iter().enumerate().take(rows.len()) {
            prop_assert_eq!(rows[plane].lookups, lookups);
            prop_assert_eq!(rows[plane].hits + rows[plane].misses, lookups);
        }
        prop_assert_eq!(rows.iter().map(|row| row.misses).sum::<u64>(), c.misses);
        prop_assert_eq!(rows.iter().map(|row| row.classes.conflict).sum::<u64>(), c.conflict);
        prop_assert_eq!(rows.iter().map(|row| row.classes.compulsory).sum::<u64>(), c.compulsory);
        prop_assert_eq!(rows.iter().map(|row| row.classes.capacity).sum::<u64>(), c.capacity);
    }

    #[test]
    fn a_set_of_lines_knows_what_it_has_seen(lines in prop::collection::vec(
        prop_oneof![0u64..300, (1u64 << 24) - 100..(1 << 24) + 100, any::<u64>(), u64::MAX - 100..=u64::MAX], 1..500))
    {
        let (mut set, mut textbook) = (LineSet::default(), HashSet::new());
        for line in lines {
            prop_assert_eq!(set.insert(line), textbook.insert(line));
        }
    }
}

#[test]
fn one_fully_associative_set_of_any_policy_has_no_conflicts_under_lru() {
    let geometry = Geometry { sets: 1, ways: 24, line: 16 };
    let mut cache = TexelCache::new(geometry, Policy::Lru, 4, Detail::default()).unwrap();
    let addresses: Vec<u64> = (0..5000u64).map(|i| i * i % 1009 * 4).collect();
    cache.read_all(0, &addresses);
    let counters = cache.counters();
    assert_eq!(counters.conflict, 0);
    assert!(counters.capacity > 0 && counters.compulsory > 0);
}

#[test]
fn detail_that_was_not_asked_for_changes_nothing_else() {
    let geometry = Geometry { sets: 4, ways: 3, line: 64 };
    let addresses: Vec<u64> = (0..5000u64).map(|i| i * i % 10007 * 4).collect();
    let count = |detail| {
        let mut cache = TexelCache::new(geometry, Policy::Plru, 4, detail).unwrap();
        cache.read_all(2, &addresses);
        cache.counters()
    };
    let (all, none) = (count(Detail::default()), count(Detail { classes: false, line_use: false }));
    assert_eq!((none.lookups, none.misses, none.evictions), (all.lookups, all.misses, all.evictions));
    assert_eq!((none.compulsory, none.capacity, none.conflict, none.bytes_used), (0, 0, 0, 0));
    assert!(all.bytes_used > 0);
}

#[test]
fn shapes_that_cannot_be_built_are_refused_by_name() {
    let good = Geometry { sets: 3, ways: 24, line: 128 };
    assert_eq!(good.check(), Ok(()));
    for (geometry, key) in [
        (Geometry { sets: 0, ..good }, "sets"),
        (Geometry { ways: 0, ..good }, "ways"),
        (Geometry { line: 0, ..good }, "line"),
        (Geometry { line: 48, ..good }, "line"),
        (Geometry { line: 8192, ..good }, "line"),
        (Geometry { sets: u32::MAX, ways: u32::MAX, line: 4096 }, "ways"),
        (Geometry { sets: 1 << 27, ways: 3, line: 1 }, "sets"),
    ] {
        assert_eq!(Cache::new(geometry, Policy::Lru).unwrap_err().key, key, "{geometry:?}");
        assert_eq!(MissClassifier::new(geometry).unwrap_err().key, key, "{geometry:?}");
    }
    let narrow = Geometry { line: 2, ..good };
    assert_eq!(TexelCache::new(narrow, Policy::Lru, 4, Detail::default()).unwrap_err().key, "texel");
}
