//! Landing: what a tool does to the glass that comes down onto it along the normal, or leaves it.
//!
//! In: the job's `landing`, a speed and an acceleration. Out: how long the tool would have to stand in its place to remove as
//! much; and at which points of a path that happens.
//!
//! The model. On the way down the tool begins to remove `reach` above its place, in proportion to how much of `reach` it has
//! come down, with the whole influence function: a wider share than a real tool's first touch, so the pit is foreseen no
//! shallower than it will be. It moves at the landing's speed v and comes to rest in its place with the acceleration a. With
//! h the height and R the reach, the rate is 1 - h/R of the full one, and the speed at h the smaller of v and √(2ah):
//!
//! ```text
//! braking b = v²/2a;   b <= R:  v/a - v³/(6a²R) + (R - b)²/(2Rv)        b > R:  2/3 √(2R/a)
//! ```
//!
//! Then the controller stands for `stand`. Going up is the same, backwards.

use super::{Link, ToolPath};
use crate::diagnostics::{Problem, codes};
use crate::job::Landing;

impl ToolPath {
    /// The points at which the tool comes down or goes up, in order of travel; nothing if the path does not land. Some of these points lie
    /// off the part.
    pub fn stands(&self) -> impl Iterator<Item = usize> + '_ {
        let count = if self.landing.is_some() { self.lines.len() } else { 0 };
        (0..count).flat_map(move |i| {
            let line = &self.lines[i];
            let down = i == 0 || self.lines[i - 1].link == Link::Lifted;
            let up = i + 1 == count || line.link == Link::Lifted;
            [down.then_some(line.points.start), up.then_some(line.points.end - 1)].into_iter().flatten()
        })
    }
}

/// Seconds of standing that one way down (or up) at `speed` m/s comes to, the stop included. `acceleration` in m/s².
pub fn standing(landing: &Landing, speed: f64, acceleration: f64) -> f64 {
    let (v, a, reach) = (speed, acceleration, landing.reach.0);
    let braking = v * v / (2.0 * a);
    let moving = if reach <= 0.0 {
        0.0
    } else if braking > reach {
        (2.0 * reach / a).sqrt() * 2.0 / 3.0
    } else {
        v / a - v * v * v / (6.0 * a * a * reach) + (reach - braking) * (reach - braking) / (2.0 * reach * v)
    };
    moving + landing.stand.0
}

/// E0640 for numbers that no landing has.
pub(super) fn check(landing: &Landing) -> Result<(), Problem> {
    let refuse = |name: &str, what: String| {
        Err(Problem::error(codes::E0640, format!("path.landing.{name}"), format!("the landing's {what}")))
    };
    let Landing { speed, reach, stand } = landing;
    if !(speed.0 > 0.0 && speed.0.is_finite()) {
        return refuse("speed", format!("`speed` is {} mm/s; it must be positive", speed.0 * 1e3));
    }
    if !(reach.0 >= 0.0 && reach.0.is_finite()) {
        return refuse("reach", format!("`reach` is {} mm; it cannot be negative", reach.0 * 1e3));
    }
    if !(stand.0 >= 0.0 && stand.0.is_finite()) {
        return refuse("stand", format!("`stand` is {} s; it cannot be negative", stand.0));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::{Line, Points};
    use crate::units::si::{Length, Speed, Time};

    fn landing(speed: f64, reach: f64, stand: f64) -> Landing {
        Landing { speed: Speed(speed), reach: Length(reach), stand: Time(stand) }
    }

    /// The share of the rate, summed over small steps of time backwards from rest: h = a t²/2 until v is reached, then h grows
    /// by v a second.
    fn by_steps(v: f64, a: f64, reach: f64) -> f64 {
        let (mut h, mut speed, mut sum) = (0.0, 0.0, 0.0);
        let dt = 1e-6;
        while h < reach {
            let next = f64::min(v, speed + a * dt);
            let middle = h + (speed + next) / 4.0 * dt;
            sum += dt * (1.0 - middle / reach).max(0.0);
            h += (speed + next) / 2.0 * dt;
            speed = next;
        }
        sum
    }

    #[test]
    fn coming_down_is_standing_for_a_while() {
        // Slow, with a short braking way; fast, so that it brakes all through the reach; and where both are as long.
        for (v, a, reach) in [(0.01, 0.5, 2e-3), (0.1, 0.5, 2e-3), (0.02, 0.5, 4e-4), (0.005, 5.0, 0.01)] {
            let (found, expected) = (standing(&landing(v, reach, 0.0), v, a), by_steps(v, a, reach));
            assert!((found - expected).abs() < 1e-4 * expected + 2e-6, "{v} {a} {reach}: {found} {expected}");
        }
        // By hand: 10 mm/s, 0.5 m/s², 2 mm. Braking 0.1 mm: 0.02 - 1e-6/(6*0.25*2e-3) + (1.9e-3)²/(4e-5) = 0.02 - 0.000333
        // + 0.09025, and a fifth of a second of standing.
        assert!((standing(&landing(0.01, 2e-3, 0.2), 0.01, 0.5) - 0.309_916_666_7).abs() < 1e-9);
        assert_eq!(standing(&landing(0.01, 0.0, 0.25), 0.01, 0.5), 0.25);
    }

    #[test]
    fn the_tool_stands_where_it_is_lifted_and_at_both_ends() {
        let line = |points, link| Line { points, link };
        let lines = vec![
            line(0..4, Link::OnSurface),
            line(4..6, Link::Lifted),
            line(6..9, Link::Lifted),
            line(9..12, Link::OnSurface),
        ];
        let mut path = ToolPath { points: Points::default(), lines, ..ToolPath::default() };
        assert_eq!(path.stands().count(), 0);
        path.landing = Some(landing(0.01, 1e-3, 0.1));
        assert_eq!(path.stands().collect::<Vec<usize>>(), [0, 5, 6, 8, 9, 11]);
    }

    #[test]
    fn numbers_that_no_landing_has_are_refused() {
        assert!(check(&landing(0.01, 0.0, 0.0)).is_ok());
        for bad in [landing(0.0, 0.0, 0.0), landing(0.01, -1e-3, 0.0), landing(0.01, 0.0, f64::NAN)] {
            assert_eq!(check(&bad).expect_err("no landing").code, codes::E0640);
        }
    }
}
