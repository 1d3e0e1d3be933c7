//! Rotations and rigid frames for tests, by quaternions and by matrices, written out from their definitions.

/// [w, x, y, z].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion(pub [f64; 4]);

impl Quaternion {
    /// Hamilton's product: first `other`, then `self`.
    pub fn times(&self, other: &Quaternion) -> Quaternion {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Quaternion([
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        ])
    }

    /// q v q*.
    pub fn rotate(&self, v: [f64; 3]) -> [f64; 3] {
        let [w, x, y, z] = self.0;
        let turned = self.times(&Quaternion([0.0, v[0], v[1], v[2]])).times(&Quaternion([w, -x, -y, -z]));
        [turned.0[1], turned.0[2], turned.0[3]]
    }
}

/// A frame in another: where its origin stands and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    pub at: [f64; 3],
    pub turn: Quaternion,
}

impl Pose {
    pub const IDENTITY: Pose = Pose { at: [0.0; 3], turn: Quaternion([1.0, 0.0, 0.0, 0.0]) };

    /// A point of this frame, in the outer one.
    pub fn place(&self, p: [f64; 3]) -> [f64; 3] {
        let turned = self.turn.rotate(p);
        std::array::from_fn(|i| self.at[i] + turned[i])
    }

    /// `inner`, a frame in this one, in the outer one.
    pub fn then(&self, inner: &Pose) -> Pose {
        Pose { at: self.place(inner.at), turn: self.turn.times(&inner.turn) }
    }

    /// The same as a matrix, the quaternion taken as it is written.
    pub fn matrix(&self) -> Frame {
        let axes: [[f64; 3]; 3] =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| self.turn.rotate(axis));
        Frame { turn: std::array::from_fn(|row| std::array::from_fn(|column| axes[column][row])), at: self.at }
    }
}

/// A frame in another: the columns of `turn` are its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub turn: [[f64; 3]; 3],
    pub at: [f64; 3],
}

impl Frame {
    /// R = Rz(z) Ry(y) Rx(x), degrees: the job's `zyx_intrinsic`.
    pub fn zyx(at: [f64; 3], [z, y, x]: [f64; 3]) -> Frame {
        let ((sz, cz), (sy, cy), (sx, cx)) =
            (z.to_radians().sin_cos(), y.to_radians().sin_cos(), x.to_radians().sin_cos());
        let rz = [[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]];
        let ry = [[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]];
        let rx = [[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]];
        Frame { turn: product(&product(&rz, &ry), &rx), at }
    }

    /// A direction of this frame, in the outer one.
    pub fn direct(&self, v: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|row| (0..3).map(|k| self.turn[row][k] * v[k]).sum())
    }

    /// A point of this frame, in the outer one.
    pub fn place(&self, p: [f64; 3]) -> [f64; 3] {
        let turned = self.direct(p);
        std::array::from_fn(|i| self.at[i] + turned[i])
    }

    /// `inner`, a frame in this one, in the outer one.
    pub fn then(&self, inner: &Frame) -> Frame {
        Frame { turn: product(&self.turn, &inner.turn), at: self.place(inner.at) }
    }

    /// The outer frame in this one.
    pub fn inverse(&self) -> Frame {
        let turn = std::array::from_fn(|row| std::array::from_fn(|column| self.turn[column][row]));
        let back = Frame { turn, at: [0.0; 3] };
        Frame { turn, at: back.direct(self.at).map(|x| -x) }
    }

    /// Column `k` of the rotation: the axis of this frame in the outer one.
    pub fn axis(&self, k: usize) -> [f64; 3] {
        std::array::from_fn(|row| self.turn[row][k])
    }
}

fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|row| std::array::from_fn(|column| (0..3).map(|k| a[row][k] * b[k][column]).sum()))
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The unit vector along `a`.
pub fn normalised(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    dot(d, d).sqrt()
}

/// The angle between two directions, degrees; exact where it is small.
pub fn degrees_between(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    dot(cross, cross).sqrt().atan2(dot(a, b)).to_degrees()
}
