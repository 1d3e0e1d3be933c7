//! The turn limit: no path turns more sharply than the arm is asked to.
//!
//! At a dead end a path turns back on itself, and no smoothing mends that. There it is cut in two: the tool lifts, and comes
//! down again at the same place on its new way.

use super::smooth::{Ends, Place, smooth, turns};

/// Smooths a path and cuts it where the curve turns by more than `limit` radians from node to node. The node at a cut belongs to
/// both pieces, as an end of each, which smoothing leaves in its place; so the pieces are smoothed and looked at anew.
pub fn pieces(nodes: Vec<Place>, weights: &[f64], limit: f64) -> Vec<Vec<Place>> {
    let mut done = Vec::new();
    let mut left = vec![nodes];
    while let Some(nodes) = left.pop() {
        let curve = smooth(&nodes, weights, Ends::Reflected);
        let turns = turns(&curve);
        // The first of a run of sharp turns would leave the others in the next piece: the sharpest is cut first.
        let sharpest = (1..nodes.len().max(1) - 1).fold(None, |best: Option<usize>, i| match best {
            Some(b) if turns[b] >= turns[i] => best,
            _ => Some(i),
        });
        match sharpest.filter(|i| turns[*i] > limit) {
            Some(i) => {
                left.push(nodes[i..].to_vec());
                left.push(nodes[..=i].to_vec());
            }
            None => done.push(curve),
        }
    }
    done
}
