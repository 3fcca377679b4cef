//! The table after the run: each function's median, and its share of a cycle at three rates.

use crate::functions::Level;
use std::fmt;

/// Control rates, kHz.
const RATES: [f64; 3] = [1.0, 4.0, 8.0];

/// The builds, in the order of the table's columns.
const LEVELS: [Level; 3] = [Level::Portable, Level::Avx2, Level::Avx512];

/// A function with a robot of so many joints: its median in ns in each build.
struct Row {
    function: &'static str,
    joints: usize,
    ns: [Option<f64>; LEVELS.len()],
}

/// What was measured, in the order of the functions.
#[derive(Default)]
pub struct Budget {
    cycles: Vec<Row>,
    batches: Vec<Row>,
    yardsticks: Vec<(usize, f64)>,
}

impl Budget {
    /// Enters the time of one call.
    pub fn cycle(&mut self, function: &'static str, joints: usize, level: Level, ns: f64) {
        enter(&mut self.cycles, function, joints, level, ns);
    }

    /// Enters the time of the library's sines and cosines of so many angles.
    pub fn yardstick(&mut self, angles: usize, ns: f64) {
        self.yardsticks.push((angles, ns));
    }

    /// Enters the time of one configuration in a batch.
    pub fn batch(&mut self, function: &'static str, joints: usize, level: Level, ns: f64) {
        enter(&mut self.batches, function, joints, level, ns);
    }
}

/// Enters a time into its row; the rows of one function stay together.
fn enter(rows: &mut Vec<Row>, function: &'static str, joints: usize, level: Level, ns: f64) {
    let place = rows.iter().position(|row| (row.function, row.joints) == (function, joints)).unwrap_or_else(|| {
        let after = rows.iter().rposition(|row| row.function == function).map_or(rows.len(), |last| last + 1);
        rows.insert(after, Row { function, joints, ns: [None; LEVELS.len()] });
        after
    });
    rows[place].ns[level as usize] = Some(ns);
}

/// A number with so many decimals, or a dash.
fn cell(x: Option<f64>, decimals: usize) -> String {
    x.map_or_else(|| "-".to_owned(), |x| format!("{x:.decimals$}"))
}

impl fmt::Display for Budget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.cycles.is_empty() {
            let [a, b, c] = RATES.map(|rate| format!("% of {rate} kHz"));
            writeln!(f, "\nTiming budget: median of one call, and its share of a cycle in the best build\n")?;
            writeln!(
                f,
                "{:<28}{:>6}{:>14}{:>10}{a:>12}{b:>12}{c:>12}",
                "function", "joints", "portable ns", "avx2 ns"
            )?;
        }
        for Row { function, joints, ns: [portable, avx2, _] } in &self.cycles {
            // 1 ns of a cycle of 1/rate ms is 1e-4 rate percent.
            let [a, b, c] = RATES.map(|rate| cell(avx2.or(*portable).map(|ns| ns * rate * 1e-4), 4));
            let (portable, avx2) = (cell(*portable, 1), cell(*avx2, 1));
            writeln!(f, "{function:<28}{joints:>6}{portable:>14}{avx2:>10}{a:>12}{b:>12}{c:>12}")?;
        }
        if !self.batches.is_empty() {
            writeln!(
                f,
                "\nBatch kernels: time per configuration on one core, and millions of configurations per second\n"
            )?;
            write!(f, "{:<28}{:>6}", "function", "joints")?;
            LEVELS.iter().try_for_each(|level| write!(f, "{:>12} ns{:>7}", level.name(), "M/s"))?;
            writeln!(f)?;
        }
        for Row { function, joints, ns } in &self.batches {
            write!(f, "{function:<28}{joints:>6}")?;
            ns.iter().try_for_each(|ns| write!(f, "{:>15}{:>7}", cell(*ns, 1), cell(ns.map(|ns| 1e3 / ns), 1)))?;
            writeln!(f)?;
        }
        let scale: Vec<_> = self.yardsticks.iter().map(|(angles, ns)| format!("{ns:.1} ns for {angles}")).collect();
        if !scale.is_empty() {
            writeln!(
                f,
                "\nFor scale, the standard library's sines and cosines of as many angles: {}",
                scale.join(", ")
            )?;
        }
        Ok(())
    }
}
