//! The textbook cache: records that remember everything, searched one by one, and what follows from them by definition.

use std::collections::{BTreeMap, HashSet};

use texunit_hw::cache::{Geometry, Outcome, Policy};

/// One way of the textbook cache.
#[derive(Clone, Copy)]
struct Record {
    line: u64,
    used: usize,
    filled: usize,
}

/// A node of the textbook pseudo-LRU tree: it covers ways `first..first + span` and points at one half.
enum Tree {
    Way,
    Node { half: usize, points_up: bool, lower: Box<Tree>, upper: Box<Tree> },
}

impl Tree {
    fn new(span: usize) -> Self {
        match span {
            1 => Self::Way,
            _ => Self::Node {
                half: span / 2,
                points_up: false,
                lower: Box::new(Self::new(span / 2)),
                upper: Box::new(Self::new(span / 2)),
            },
        }
    }

    fn touch(&mut self, way: usize) {
        if let Self::Node { half, points_up, lower, upper } = self {
            *points_up = way < *half;
            if way < *half { lower.touch(way) } else { upper.touch(way - *half) }
        }
    }

    /// The way pointed at among the first `ways`.
    fn victim(&self, ways: usize) -> usize {
        match self {
            Self::Way => 0,
            Self::Node { half, points_up: true, upper, .. } if ways > *half => half + upper.victim(ways - half),
            Self::Node { half, lower, .. } => lower.victim(ways.min(*half)),
        }
    }
}

pub struct Textbook {
    geometry: Geometry,
    policy: Policy,
    sets: BTreeMap<u64, (Vec<Record>, Tree)>,
    generator: u64,
    time: usize,
}

impl Textbook {
    pub fn new(geometry: Geometry, policy: Policy) -> Self {
        let generator = if let Policy::Random { seed } = policy { seed } else { 0 };
        Self { geometry, policy, sets: BTreeMap::new(), generator, time: 0 }
    }

    pub fn access(&mut self, address: u64) -> Outcome {
        let line = address / u64::from(self.geometry.line);
        let set = line % u64::from(self.geometry.sets);
        let ways = self.geometry.ways as usize;
        let slot = |way: usize| (set * ways as u64 + way as u64) as u32;
        self.time += 1;
        let time = self.time;
        let (records, tree) = self.sets.entry(set).or_insert_with(|| (vec![], Tree::new(ways.next_power_of_two())));
        if let Some(way) = records.iter().position(|record| record.line == line) {
            records[way].used = time;
            tree.touch(way);
            return Outcome::Hit { slot: slot(way) };
        }
        let record = Record { line, used: time, filled: time };
        let way = if records.len() < ways {
            records.push(record);
            tree.touch(records.len() - 1);
            return Outcome::Miss { slot: slot(records.len() - 1), evicted: None };
        } else {
            match self.policy {
                Policy::Lru => (0..ways).min_by_key(|&way| records[way].used).unwrap(),
                Policy::Fifo => (0..ways).min_by_key(|&way| records[way].filled).unwrap(),
                Policy::Plru => tree.victim(ways),
                Policy::Random { .. } => {
                    self.generator = self.generator.wrapping_add(0x9e3779b97f4a7c15);
                    let z = self.generator;
                    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58476d1ce4e5b9);
                    let z = (z ^ (z >> 27)).wrapping_mul(0x94d049bb133111eb);
                    let z = z ^ (z >> 31);
                    (u128::from(z) * ways as u128 / (1u128 << 64)) as usize
                }
            }
        };
        let evicted = Some(records[way].line);
        records[way] = record;
        tree.touch(way);
        Outcome::Miss { slot: slot(way), evicted }
    }
}

/// Compulsory, capacity and conflict misses by their definitions.
pub fn textbook_classes(geometry: Geometry, policy: Policy, addresses: &[u64]) -> [u64; 3] {
    let (mut cache, mut seen, mut recent) = (Textbook::new(geometry, policy), HashSet::new(), Vec::<u64>::new());
    let mut classes = [0; 3];
    for &address in addresses {
        let line = address / u64::from(geometry.line);
        let there = recent.iter().position(|&held| held == line);
        if let Some(at) = there {
            recent.remove(at);
        }
        recent.insert(0, line);
        recent.truncate(geometry.lines() as usize);
        let first = seen.insert(line);
        if !cache.access(address).is_hit() {
            classes[if first {
                0
            } else if there.is_none() {
                1
            } else {
                2
            }] += 1;
        }
    }
    classes
}

/// Bytes of each fetch that were used, by sets of bytes.
pub fn textbook_use(geometry: Geometry, policy: Policy, texel: u64, addresses: &[u64]) -> u64 {
    let (mut cache, mut used, mut total) = (Textbook::new(geometry, policy), BTreeMap::new(), 0);
    for &address in addresses {
        let outcome = cache.access(address);
        let bytes: &mut HashSet<u64> = used.entry(outcome.slot()).or_default();
        if !outcome.is_hit() {
            total += bytes.len() as u64;
            bytes.clear();
        }
        let first = address - address % texel;
        bytes.extend((0..texel).map(|byte| first + byte));
    }
    total + used.values().map(|bytes| bytes.len() as u64).sum::<u64>()
}
