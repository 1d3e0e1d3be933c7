//! Merging: fewer paths out of those that filling gave, so that the tool is lifted less often.
//!
//! Two rules. [`paper`] is that of the paper, its pseudo-code put right: the tail of a path is cut off where the next path starts
//! beside it. What is cut off is left unpolished, and nobody asks how much. [`bridge_or_trim`] looks at what it leaves: it cuts
//! only what the path passes on two sides, or goes over ground that was visited already, and drops a short path only if the
//! others reach all of it.

use super::mesh::{Cells, Hexagon, Mesh, Sheet};
use super::smooth::{Ends, Place, smooth, turns};
use std::collections::VecDeque;

/// Paths after a merge, and what it did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Merged {
    pub paths: Vec<Vec<Hexagon>>,
    /// Hexagons cut off the ends of paths that go on elsewhere.
    pub trimmed: usize,
    /// Hexagons of paths that were dropped because they are short.
    pub dropped: usize,
    /// Hexagons visited once more, on the way from one path to the next.
    pub bridged: usize,
}

/// The paper's rule. Where a path starts beside one of the last `tail` hexagons of the path so far (the last of them counts), it
/// goes on from there, and what came behind is dropped. Paths of fewer than `shortest` hexagons are dropped in the end.
pub fn paper(primary: Vec<Vec<Hexagon>>, tail: usize, shortest: usize) -> Merged {
    let mut merged = Merged::default();
    let mut current: Vec<Hexagon> = Vec::new();
    for path in primary {
        let Some(first) = path.first().copied() else { continue };
        let from = current.len().saturating_sub(tail);
        match current[from..].iter().rposition(|hexagon| hexagon.distance(first) == 1) {
            Some(place) => {
                merged.trimmed += current.len() - (from + place + 1);
                current.truncate(from + place + 1);
                current.extend(path);
            }
            None => {
                merged.paths.push(std::mem::replace(&mut current, path));
            }
        }
    }
    merged.paths.push(current);
    let all: usize = merged.paths.iter().map(Vec::len).sum();
    merged.paths.retain(|path| !path.is_empty() && path.len() >= shortest);
    merged.dropped = all - merged.paths.iter().map(Vec::len).sum::<usize>();
    merged
}

/// What [`bridge_or_trim`] may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Within<'a> {
    /// Most hexagons that a joint may cut off and bridge, together.
    pub steps: usize,
    /// Paths of fewer hexagons than this are dropped if the others reach all of them.
    pub shortest: usize,
    /// The window that the path will be smoothed with, and the sharpest turn, radians, that a joint may then have. A path is
    /// cut apart where it turns more sharply, so that a sharper joint would save no lift.
    pub weights: &'a [f64],
    pub turn_limit: f64,
}

/// What turning back on itself costs, where that is allowed: as much as bridging three hexagons.
const TURN_BACK: usize = 3;

/// The rule of this compiler, for the paths of one connected part, in the order in which they were filled.
///
/// A path is joined to the one before it where that is cheapest: some hexagons of the tail are cut off, if the paths pass each
/// of them on two sides, and the way to the next path's start or end is bridged over hexagons of the part. Each hexagon
/// cut off or bridged costs one, and they may be `within.steps` at most. Where nothing is near enough, or the joint would turn too
/// sharply, the path ends.
pub fn bridge_or_trim(primary: Vec<Vec<Hexagon>>, cells: &Cells, within: &Within) -> Merged {
    let mut merged = Merged::default();
    let mut visits = Visits::new(cells, &primary);
    let mut ways = Ways::new(cells.sheet());
    let mut current: Vec<Hexagon> = Vec::new();
    for path in primary {
        if current.is_empty() {
            current = path;
            continue;
        }
        let Some(joint) = best_joint(&current, &path, cells, &mut visits, &mut ways, within) else {
            merged.paths.push(std::mem::replace(&mut current, path));
            continue;
        };
        for hexagon in current.drain(current.len() - joint.trim..) {
            visits.take(hexagon);
        }
        joint.bridge.iter().for_each(|hexagon| visits.add(*hexagon));
        merged.trimmed += joint.trim;
        merged.bridged += joint.bridge.len();
        current.extend(joint.bridge);
        if joint.reversed {
            current.extend(path.into_iter().rev());
        } else {
            current.extend(path);
        }
    }
    if !current.is_empty() {
        merged.paths.push(current);
    }
    // Short paths, one after the other: what an earlier one left bare a later one may not leave too.
    let mut kept = Vec::new();
    for path in std::mem::take(&mut merged.paths) {
        if path.len() < within.shortest {
            path.iter().for_each(|hexagon| visits.take(*hexagon));
            // A single hexagon is no path: the tool would have to stand. One step from a path it is left to that.
            let alone = path.len() == 1 && path.iter().all(|hexagon| visits.beside(*hexagon));
            if alone || path.iter().all(|hexagon| visits.reached_around(*hexagon)) {
                merged.dropped += path.len();
                continue;
            }
            path.iter().for_each(|hexagon| visits.add(*hexagon));
        }
        kept.push(path);
    }
    merged.paths = kept;
    merged
}

/// How a path goes on into the next.
struct Joint {
    /// Hexagons cut off its tail.
    trim: usize,
    /// Hexagons between what is kept and the next path.
    bridge: Vec<Hexagon>,
    /// Whether the next path is run from its end.
    reversed: bool,
}

/// The cheapest joint; of equal ones that with the least cut off, then that which runs the next path forwards.
fn best_joint(
    current: &[Hexagon],
    next: &[Hexagon],
    cells: &Cells,
    visits: &mut Visits,
    ways: &mut Ways,
    within: &Within,
) -> Option<Joint> {
    let (first, last) = (*next.first()?, *next.last()?);
    let ends: &[(bool, Hexagon)] = if next.len() == 1 { &[(false, first)] } else { &[(false, first), (true, last)] };
    let mut best: Option<(usize, Joint)> = None;
    // What may be cut off: as long as every hexagon so left bare has a visited one beside it.
    let mut most = 0;
    while most < within.steps.min(current.len() - 1) {
        let hexagon = current[current.len() - 1 - most];
        visits.take(hexagon);
        most += 1;
        if !visits.reached_around(hexagon) {
            break;
        }
    }
    // The last taken may have been one too many; the loop below asks anew, from all taken to none.
    for trim in (0..=most).rev() {
        if trim < most {
            visits.add(current[current.len() - 1 - trim]);
        }
        let bare = &current[current.len() - trim..];
        if !bare.iter().all(|hexagon| visits.reached_around(*hexagon)) {
            continue;
        }
        let end = current[current.len() - 1 - trim];
        let back = (current.len() >= trim + 2).then(|| current[current.len() - 2 - trim]);
        for (reversed, start) in ends {
            let after = match (next.len(), reversed) {
                (1, _) => None,
                (_, false) => Some(next[1]),
                (n, true) => Some(next[n - 2]),
            };
            // A bridge may have led over the next path's end already.
            if end == *start {
                continue;
            }
            let Some(bridge) = ways.between(end, *start, cells, within.steps - trim + 1) else { continue };
            let out = bridge.first().copied().unwrap_or(*start);
            let into = bridge.last().copied().unwrap_or(end);
            let turns_back = usize::from(back == Some(out)) + usize::from(after == Some(into));
            let cost = trim + bridge.len() + TURN_BACK * turns_back;
            // Asked from the most cut off to none: an equal cost with less cut off takes its place, but not a reversed run.
            let better = |best: &(usize, Joint)| cost < best.0 || (cost == best.0 && trim < best.1.trim);
            if best.as_ref().is_none_or(better) {
                let kept = &current[..current.len() - trim];
                if sharpest_turn(kept, &bridge, next, *reversed, within.weights) > within.turn_limit {
                    continue;
                }
                best = Some((cost, Joint { trim, bridge, reversed: *reversed }));
            }
        }
    }
    best.map(|(_, joint)| joint)
}

/// The sharpest turn of a joint once it is smoothed, radians.
fn sharpest_turn(kept: &[Hexagon], bridge: &[Hexagon], next: &[Hexagon], reversed: bool, weights: &[f64]) -> f64 {
    // What lies a window away from the joint is not changed by it; a window more, and the cut ends do not matter.
    let window = weights.len();
    let before = &kept[kept.len().saturating_sub(2 * window)..];
    let after =
        &next[if reversed { next.len().saturating_sub(2 * window)..next.len() } else { 0..next.len().min(2 * window) }];
    let mut hexagons: Vec<Hexagon> = before.iter().chain(bridge).copied().collect();
    if reversed {
        hexagons.extend(after.iter().rev());
    } else {
        hexagons.extend(after);
    }
    let unit = Mesh { diagonal: 1.0, centre: [0.0; 2] };
    let nodes: Vec<Place> = hexagons.into_iter().map(|hexagon| unit.place(hexagon)).collect();
    let from = before.len().saturating_sub(window);
    let to = (before.len() + bridge.len() + window).min(nodes.len());
    turns(&smooth(&nodes, weights, Ends::Reflected))[from..to].iter().copied().fold(0.0, f64::max)
}

/// How often each hexagon is visited.
struct Visits<'a> {
    cells: &'a Cells,
    count: Vec<u32>,
}

impl<'a> Visits<'a> {
    fn new(cells: &'a Cells, paths: &[Vec<Hexagon>]) -> Visits<'a> {
        let mut visits = Visits { cells, count: vec![0; cells.sheet().len()] };
        paths.iter().flatten().for_each(|hexagon| visits.add(*hexagon));
        visits
    }

    fn add(&mut self, hexagon: Hexagon) {
        if let Some(index) = self.cells.sheet().index(hexagon) {
            self.count[index] += 1;
        }
    }

    fn take(&mut self, hexagon: Hexagon) {
        if let Some(index) = self.cells.sheet().index(hexagon) {
            self.count[index] -= 1;
        }
    }

    fn visited(&self, hexagon: Hexagon) -> bool {
        self.cells.sheet().index(hexagon).is_some_and(|index| self.count[index] > 0)
    }

    /// Whether a neighbour is visited.
    fn beside(&self, hexagon: Hexagon) -> bool {
        (0..6).any(|k| self.visited(hexagon.neighbour(k)))
    }

    /// Visited, or between two that are: neighbours that lie beside each other both miss the same corner of the hexagon by a
    /// third of a diagonal, any other two leave none of it farther away than a diagonal.
    fn reached(&self, hexagon: Hexagon) -> bool {
        let around: [bool; 6] = std::array::from_fn(|k| self.visited(hexagon.neighbour(k as i32)));
        self.visited(hexagon) || (0..6).any(|k| around[k] && (2..=4).any(|apart| around[(k + apart) % 6]))
    }

    /// Whether a hexagon and all neighbours that belong to the part are reached.
    fn reached_around(&self, hexagon: Hexagon) -> bool {
        self.reached(hexagon)
            && (0..6).map(|k| hexagon.neighbour(k)).all(|h| !self.cells.contains(h) || self.reached(h))
    }
}

/// Shortest ways over the hexagons of a part.
struct Ways {
    sheet: Sheet,
    /// Where a hexagon was reached from, of the search with that number.
    from: Vec<(u32, Hexagon)>,
    search: u32,
    queue: VecDeque<(Hexagon, usize)>,
}

impl Ways {
    fn new(sheet: Sheet) -> Ways {
        Ways { sheet, from: vec![(0, Hexagon::default()); sheet.len()], search: 0, queue: VecDeque::new() }
    }

    /// The hexagons between `start` and `end` on a shortest way of at most `most` steps, directions tried in their order.
    fn between(&mut self, start: Hexagon, end: Hexagon, cells: &Cells, most: usize) -> Option<Vec<Hexagon>> {
        if start.distance(end) as usize > most {
            return None;
        }
        self.search += 1;
        self.queue.clear();
        self.queue.push_back((end, 0));
        if let Some(index) = self.sheet.index(end) {
            self.from[index] = (self.search, end);
        }
        // Searched from the end, so that the way reads forwards.
        while let Some((at, steps)) = self.queue.pop_front() {
            if at == start {
                let mut way = Vec::new();
                let mut at = start;
                while at != end {
                    at = self.sheet.index(at).map_or(end, |index| self.from[index].1);
                    way.push(at);
                }
                way.pop();
                return Some(way);
            }
            if steps == most {
                continue;
            }
            for neighbour in (0..6).map(|k| at.neighbour(k)) {
                let Some(index) = self.sheet.index(neighbour) else { continue };
                if cells.contains(neighbour) && self.from[index].0 != self.search {
                    self.from[index] = (self.search, at);
                    self.queue.push_back((neighbour, steps + 1));
                }
            }
        }
        None
    }
}
