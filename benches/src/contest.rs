//! Times of the model beside times of something else, taken in turns: machines are shared, and only ratios within a round mean much.

use std::{hint::black_box, time::Instant};

/// What a row is held to.
#[derive(Clone, Copy, Debug)]
pub enum Goal {
    /// Times as fast as what it is measured against, at least.
    Speed(f64),
    /// Times as long, at most.
    Cost(f64),
    /// For information.
    None,
}

/// One measurement: the model against something.
pub struct Row<'a> {
    /// What is measured.
    pub name: &'a str,
    /// Against what.
    pub against: &'a str,
    /// What is aimed at.
    pub goal: Goal,
    /// Pieces of work each does in a round.
    pub work: usize,
    /// Seconds of what it is measured against and of the model, in each round.
    pub times: Vec<[f64; 2]>,
}

impl std::fmt::Debug for Row<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// Seconds that something takes.
pub fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let begin = Instant::now();
    black_box(work());
    begin.elapsed().as_secs_f64()
}

impl Row<'_> {
    /// The median over the rounds.
    pub fn median(&self, pick: impl Fn(&[f64; 2]) -> f64) -> f64 {
        let mut values: Vec<f64> = self.times.iter().map(pick).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    }

    /// The figure the goal speaks of: speed, or cost.
    pub fn figure(&self) -> f64 {
        match self.goal {
            Goal::Cost(_) => self.median(|[other, model]| model / other),
            _ => self.median(|[other, model]| other / model),
        }
    }

    /// Whether the goal is reached, where there is one.
    pub fn reached(&self) -> Option<bool> {
        match self.goal {
            Goal::Speed(goal) => Some(self.figure() >= goal),
            Goal::Cost(goal) => Some(self.figure() <= goal),
            Goal::None => None,
        }
    }

    /// As a line of a table.
    pub fn line(&self) -> String {
        let goal = match self.goal {
            Goal::Speed(goal) => format!(">= {goal:.2}"),
            Goal::Cost(goal) => format!("<= {goal:.2}"),
            Goal::None => String::new(),
        };
        let verdict = match self.reached() {
            Some(true) => "reached",
            Some(false) => "missed",
            None => "",
        };
        let rate = self.work as f64 / self.median(|times| times[1]) / 1e6;
        format!("{:<52} {:<34} {:>7.2} {goal:>8} {verdict:<8} {rate:>9.1}", self.name, self.against, self.figure())
    }

    /// As JSON.
    pub fn json(&self) -> serde_json::Value {
        let (kind, goal) = match self.goal {
            Goal::Speed(goal) => ("times as fast, at least", Some(goal)),
            Goal::Cost(goal) => ("times as long, at most", Some(goal)),
            Goal::None => ("times as fast", None),
        };
        serde_json::json!({
            "name": self.name, "against": self.against, "kind": kind, "goal": goal, "figure": self.figure(),
            "reached": self.reached(), "speed of each round": self.times.iter().map(|[other, model]| other / model).collect::<Vec<_>>(),
        })
    }
}
