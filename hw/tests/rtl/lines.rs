//! Which lines a set-associative LRU cache holds, as lists: slow, obvious, and sharing nothing with `texunit_hw`.

/// The lines of every set, least recently used first.
pub struct RecentLines {
    ways: usize,
    /// Line (if any) and way, oldest use first.
    sets: Vec<Vec<(Option<u64>, usize)>>,
}

impl RecentLines {
    /// An empty cache.
    pub fn new(sets: u64, ways: usize) -> Self {
        Self { ways, sets: vec![(0..ways).map(|way| (None, way)).collect(); sets as usize] }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        *self = Self::new(self.sets.len() as u64, self.ways);
    }

    /// Whether a line is there, and the way it is in or would go to.
    pub fn find(&self, line: u64) -> (bool, usize) {
        let set = &self.sets[(line % self.sets.len() as u64) as usize];
        match set.iter().find(|(held, _)| *held == Some(line)) {
            Some((_, way)) => (true, *way),
            None => (false, set[0].1),
        }
    }

    /// Uses a line; the answer is whether it was there.
    pub fn touch(&mut self, line: u64) -> bool {
        let count = self.sets.len() as u64;
        let set = &mut self.sets[(line % count) as usize];
        let hit = set.iter().position(|(held, _)| *held == Some(line));
        let (_, way) = set.remove(hit.unwrap_or(0));
        set.push((Some(line), way));
        hit.is_some()
    }
}
