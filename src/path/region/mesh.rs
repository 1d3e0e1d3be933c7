//! The mesh: hexagons that cover the plane, and sets of them.
//!
//! A hexagon has its flat sides up and down. It is named by two whole numbers, `p` and `q` (axial coordinates); its
//! centre lies at `x = 3/4 p d`, `y = sqrt(3)/2 (q + p/2) d` from the mesh's centre, `d` being its diagonal from corner to
//! corner. All six neighbours lie `sqrt(3)/2 d` away, at 30, 90, 150 … degrees; columns lie `3/4 d` apart; a hexagon has the area
//! `3 sqrt(3)/8 d²`. (Region-adaptive paper, equations 2 and 3; the printed `3/2` of `y` has lost its root.)

/// A hexagon of the mesh. Ordered by `p`, then `q`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Hexagon {
    pub p: i32,
    pub q: i32,
}

/// Steps to the six neighbours, counter-clockwise: direction `k` points to `30 + 60 k` degrees.
pub const DIRECTIONS: [[i32; 2]; 6] = [[1, 0], [0, 1], [-1, 1], [-1, 0], [0, -1], [1, -1]];

impl Hexagon {
    /// The neighbour in a direction, counted round and round (6 is 0, -1 is 5).
    pub fn neighbour(self, direction: i32) -> Hexagon {
        let [p, q] = DIRECTIONS[direction.rem_euclid(6) as usize];
        Hexagon { p: self.p + p, q: self.q + q }
    }

    /// Steps from hexagon to hexagon on the shortest way.
    pub fn distance(self, other: Hexagon) -> u32 {
        let (dp, dq) = (other.p - self.p, other.q - self.q);
        dp.unsigned_abs().max(dq.unsigned_abs()).max((dp + dq).unsigned_abs())
    }

    /// Square of the distance of the centres, in units of a step squared: exact.
    pub fn square(self, other: Hexagon) -> i64 {
        let (dp, dq) = (i64::from(other.p - self.p), i64::from(other.q - self.q));
        dp * dp + dp * dq + dq * dq
    }

    /// The direction in which `other`, a neighbour, lies; `None` if it is none.
    pub fn direction_to(self, other: Hexagon) -> Option<i32> {
        (0..6).find(|k| self.neighbour(*k) == other)
    }
}

/// Where the hexagons lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mesh {
    /// From corner to corner.
    pub diagonal: f64,
    /// Centre of hexagon (0, 0), in the unit of the diagonal.
    pub centre: [f64; 2],
}

impl Mesh {
    /// Distance of two neighbours' centres.
    pub fn step(&self) -> f64 {
        half_root_3() * self.diagonal
    }

    /// Area of a hexagon.
    pub fn area(&self) -> f64 {
        0.75 * half_root_3() * self.diagonal * self.diagonal
    }

    /// Centre of a hexagon.
    pub fn place(&self, hexagon: Hexagon) -> [f64; 2] {
        let (p, q) = (f64::from(hexagon.p), f64::from(hexagon.q));
        [self.centre[0] + 0.75 * self.diagonal * p, self.centre[1] + half_root_3() * self.diagonal * (q + p / 2.0)]
    }

    /// The hexagon that holds a place: the one whose centre is nearest. Three coordinates that sum to zero are rounded, and
    /// the one with the largest rounding error is taken from the other two.
    pub fn nearest(&self, [x, y]: [f64; 2]) -> Hexagon {
        let p = (x - self.centre[0]) / (0.75 * self.diagonal);
        let q = (y - self.centre[1]) / (half_root_3() * self.diagonal) - p / 2.0;
        let s = -p - q;
        let (rp, rq, rs) = (p.round(), q.round(), s.round());
        let (ep, eq, es) = ((rp - p).abs(), (rq - q).abs(), (rs - s).abs());
        let (p, q) = if ep > eq && ep > es {
            (-rq - rs, rq)
        } else if eq > es {
            (rp, -rp - rs)
        } else {
            (rp, rq)
        };
        Hexagon { p: p as i32, q: q as i32 }
    }

    /// A sheet that holds every hexagon whose centre lies in the box, and one more on every side.
    pub fn sheet(&self, min: [f64; 2], max: [f64; 2]) -> Sheet {
        let corners = [min, [min[0], max[1]], [max[0], min[1]], max].map(|corner| self.nearest(corner));
        let least = |of: fn(&Hexagon) -> i32| corners.iter().map(of).min().unwrap_or(0) - 2;
        let most = |of: fn(&Hexagon) -> i32| corners.iter().map(of).max().unwrap_or(0) + 2;
        let low = Hexagon { p: least(|h| h.p), q: least(|h| h.q) };
        Sheet { low, columns: (most(|h| h.p) - low.p + 1) as usize, rows: (most(|h| h.q) - low.q + 1) as usize }
    }

    /// How many hexagons a sheet over the box would hold, without making it.
    pub fn count(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        let (width, height) = (max[0] - min[0], max[1] - min[1]);
        let columns = width / (0.75 * self.diagonal) + 5.0;
        columns * (height / self.step() + columns / 2.0 + 5.0)
    }
}

fn half_root_3() -> f64 {
    3.0_f64.sqrt() / 2.0
}

/// The part of the mesh that a plan speaks of: `columns` values of `p` by `rows` values of `q` from `low` on. A hexagon's
/// index is its place in the order by `p`, then `q`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    pub low: Hexagon,
    pub columns: usize,
    pub rows: usize,
}

impl Sheet {
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The index of a hexagon; `None` off the sheet.
    pub fn index(&self, hexagon: Hexagon) -> Option<usize> {
        let (p, q) = (hexagon.p - self.low.p, hexagon.q - self.low.q);
        let on_it = p >= 0 && q >= 0 && (p as usize) < self.columns && (q as usize) < self.rows;
        on_it.then(|| p as usize * self.rows + q as usize)
    }

    pub fn hexagon(&self, index: usize) -> Hexagon {
        Hexagon { p: self.low.p + (index / self.rows) as i32, q: self.low.q + (index % self.rows) as i32 }
    }

    /// All hexagons, in order.
    pub fn iter(&self) -> impl Iterator<Item = Hexagon> + use<> {
        let sheet = *self;
        (0..sheet.len()).map(move |index| sheet.hexagon(index))
    }
}

/// A set of hexagons of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    sheet: Sheet,
    has: Vec<bool>,
    len: usize,
}

impl Cells {
    pub fn new(sheet: Sheet) -> Cells {
        Cells { sheet, has: vec![false; sheet.len()], len: 0 }
    }

    /// The hexagons of the sheet that `wanted` takes.
    pub fn of(sheet: Sheet, wanted: impl FnMut(Hexagon) -> bool) -> Cells {
        let has: Vec<bool> = sheet.iter().map(wanted).collect();
        let len = has.iter().filter(|has| **has).count();
        Cells { sheet, has, len }
    }

    /// The listed hexagons, on the smallest sheet that holds them and their neighbours.
    pub fn from_list(list: &[Hexagon]) -> Cells {
        let range = |of: fn(&Hexagon) -> i32| {
            (list.iter().map(of).min().unwrap_or(0) - 1, list.iter().map(of).max().unwrap_or(0) + 1)
        };
        let ((p0, p1), (q0, q1)) = (range(|h| h.p), range(|h| h.q));
        let low = Hexagon { p: p0, q: q0 };
        let mut cells = Cells::new(Sheet { low, columns: (p1 - p0 + 1) as usize, rows: (q1 - q0 + 1) as usize });
        for hexagon in list {
            cells.insert(*hexagon);
        }
        cells
    }

    pub fn sheet(&self) -> Sheet {
        self.sheet
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    pub fn contains(&self, hexagon: Hexagon) -> bool {
        self.sheet.index(hexagon).is_some_and(|index| self.has[index])
    }

    /// Takes a hexagon of the sheet in; off the sheet it changes nothing.
    pub fn insert(&mut self, hexagon: Hexagon) {
        if let Some(index) = self.sheet.index(hexagon) {
            self.len += usize::from(!self.has[index]);
            self.has[index] = true;
        }
    }

    pub fn remove(&mut self, hexagon: Hexagon) {
        if let Some(index) = self.sheet.index(hexagon) {
            self.len -= usize::from(self.has[index]);
            self.has[index] = false;
        }
    }

    /// Its hexagons, in order.
    pub fn iter(&self) -> impl Iterator<Item = Hexagon> + '_ {
        self.has.iter().enumerate().filter(|(_, has)| **has).map(|(index, _)| self.sheet.hexagon(index))
    }

    /// Its connected parts, each in the order in which it is reached from its first hexagon, the parts in the order of
    /// those.
    pub fn components(&self) -> Vec<Vec<Hexagon>> {
        let mut seen = Cells::new(self.sheet);
        let mut components = Vec::new();
        for start in self.iter() {
            if seen.contains(start) {
                continue;
            }
            seen.insert(start);
            let mut component = vec![start];
            let mut next = 0;
            while let Some(&hexagon) = component.get(next) {
                next += 1;
                for neighbour in (0..6).map(|k| hexagon.neighbour(k)) {
                    if self.contains(neighbour) && !seen.contains(neighbour) {
                        seen.insert(neighbour);
                        component.push(neighbour);
                    }
                }
            }
            components.push(component);
        }
        components
    }
}

/// What [`clean`] changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cleaned {
    /// Hexagons of islands that were taken out.
    pub dropped: Vec<Hexagon>,
    /// Hexagons of holes that were taken in.
    pub filled: Vec<Hexagon>,
}

/// Takes islands of at most `islands` hexagons out of `cells`, then fills holes of at most `holes` hexagons: parts of
/// `reach` that do not belong to `cells` and touch nothing outside `reach`. Nothing outside `reach` is ever taken in.
pub fn clean(cells: &mut Cells, reach: &Cells, islands: usize, holes: usize) -> Cleaned {
    let mut cleaned = Cleaned::default();
    for component in cells.components().into_iter().filter(|component| component.len() <= islands) {
        component.iter().for_each(|hexagon| cells.remove(*hexagon));
        cleaned.dropped.extend(component);
    }
    let left_out = Cells::of(reach.sheet(), |hexagon| reach.contains(hexagon) && !cells.contains(hexagon));
    let inside = |hexagon: &Hexagon| (0..6).all(|k| reach.contains(hexagon.neighbour(k)));
    for hole in left_out.components().into_iter().filter(|hole| hole.len() <= holes && hole.iter().all(inside)) {
        hole.iter().for_each(|hexagon| cells.insert(*hexagon));
        cleaned.filled.extend(hole);
    }
    cleaned
}
