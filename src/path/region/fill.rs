//! Filling: paths from hexagon to hexagon that visit every one of a set once.
//!
//! The rule is that of a walker with the right hand on the wall: counter-clockwise along the border, then along what was
//! visited, and so inwards in a spiral. Where all that is around was visited the path ends, and the next starts at the nearest
//! hexagon that is left. Every tie is broken by numbers, so that the same set always gives the same paths.
//!
//! The paper's sentence names left turns only; taken by the letter it loses the wall wherever that recedes (44 paths
//! instead of 1 on a full disc).

use super::mesh::{Cells, Hexagon};

/// Turns tried at the first step of a path, in sixths of a circle to the left: straight on first.
const FIRST: [i32; 6] = [0, 1, 2, 3, 4, 5];

/// Turns tried at every later step: the sharpest to the right first; never back.
const LATER: [i32; 5] = [-2, -1, 0, 1, 2];

/// Headings tried at the start of a later path, relative to the last one: the first that is free and has its wall on the right.
const START: [i32; 6] = [0, 1, -1, 2, -2, 3];

/// Fills the hexagons of `list`, all of which are in `free`, and takes them out of it. The first path starts at the
/// greatest `p` (the least `q` of those), towards +y.
pub fn fill(list: &[Hexagon], free: &mut Cells) -> Vec<Vec<Hexagon>> {
    let mut paths = Vec::new();
    let mut left = list.len();
    let Some(first) = list.iter().min_by_key(|hexagon| (-hexagon.p, hexagon.q)) else { return paths };
    let (mut at, mut heading) = (*first, 1);
    loop {
        free.remove(at);
        let mut path = vec![at];
        loop {
            let turns: &[i32] = if path.len() == 1 { &FIRST } else { &LATER };
            let Some(turn) = turns.iter().find(|turn| free.contains(at.neighbour(heading + **turn))) else { break };
            heading = (heading + turn).rem_euclid(6);
            at = at.neighbour(heading);
            free.remove(at);
            path.push(at);
        }
        left -= path.len();
        paths.push(path);
        if left == 0 {
            return paths;
        }
        let Some(next) = nearest(at, free) else { return paths };
        let on_the_wall = |turn: &&i32| {
            free.contains(next.neighbour(heading + **turn)) && !free.contains(next.neighbour(heading + **turn - 1))
        };
        heading += START.iter().find(on_the_wall).unwrap_or(&0);
        at = next;
    }
}

/// The hexagon of `free` at the least number of steps from `from`; of several the one with the fewest free neighbours, then
/// the nearest by distance, then the first in order. Looks ring by ring: the nearest is near, as a rule.
pub fn nearest(from: Hexagon, free: &Cells) -> Option<Hexagon> {
    if free.is_empty() {
        return None;
    }
    if free.contains(from) {
        return Some(from);
    }
    let crowd = |hexagon: Hexagon| (0..6).filter(|k| free.contains(hexagon.neighbour(*k))).count();
    let mut radius = 1;
    loop {
        // Round the ring: from its corner in direction 4, one side after the other.
        let mut at = from;
        at.q -= radius;
        let mut best = None;
        for side in 0..6 {
            for _ in 0..radius {
                if free.contains(at) {
                    let rank = (crowd(at), from.square(at), at);
                    best = Some(best.map_or(rank, |best: (usize, i64, Hexagon)| best.min(rank)));
                }
                at = at.neighbour(side);
            }
        }
        if let Some((_, _, hexagon)) = best {
            return Some(hexagon);
        }
        radius += 1;
    }
}
