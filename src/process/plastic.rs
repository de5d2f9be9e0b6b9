//! A strip that yields: bent as far as one likes, it keeps part of its bend.
//!
//! The material is elastic up to a yield stress and hardens linearly beyond (not at all: elastic, perfectly plastic). A
//! rectangular section whose outer fibres have yielded keeps an elastic core, and its moment follows the curvature k > k_Y by
//!
//! ```text
//!   M / (EI k_Y) = r u + (1 - r) (3/2 - 1/(2 u^2))      u = k / k_Y     k_Y = 2 sigma_Y / (E h)     r = E_t / E
//! ```
//!
//! (Prager and Hodge, *Theory of Perfectly Plastic Solids*, 1951, sec. 9). It unloads elastically. What a place of the strip
//! remembers is the greatest u that it was bent to, the same way always: the tool pushes from one side.
//! Otherwise it is the elastica of [`super::elastica`], with which it agrees where nothing yields.

use std::sync::Arc;

use super::elastica::Tip;

/// Stations along the strip at which is remembered how far it was bent, and steps of an integration: errors in
/// `cargo test a_strip_that_yields`.
const STATIONS: usize = 400;
/// Most of Newton's steps to a curvature; it converges from one side.
const MOST: usize = 100;

/// What the material is, and what each station of the strip, from the clamp to the free end, has gone through.
#[derive(Debug, Clone, PartialEq)]
pub struct Plastic {
    /// Curvature at which the outer fibres yield, 1/m.
    pub yields: f64,
    /// Tangent modulus beyond over Young's modulus.
    pub hardening: f64,
    /// Greatest bend at each station over that at which it yields; 1 where it never did.
    worn: Arc<[f64]>,
    /// From the clamp to the free end, m.
    length: f64,
}

/// The strip's free end, seen from the clamp: how far it is bent, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bent {
    /// Under the tool.
    pub under: f64,
    /// After the tool has left.
    pub left: f64,
    /// Greatest curvature over that at which the strip yields, of all that it has gone through.
    pub worst: f64,
}

impl Plastic {
    /// A strip (length and height, m) that has not been bent.
    pub fn new(yield_strain: f64, hardening: f64, length: f64, height: f64) -> Self {
        Self { yields: 2.0 * yield_strain / height, hardening, worn: [1.0; STATIONS + 1].into(), length }
    }

    /// Moment at a curvature beyond yield, both over what yields, and its derivative.
    fn moment(&self, u: f64) -> (f64, f64) {
        let r = self.hardening;
        (r * u + (1.0 - r) * (1.5 - 0.5 / (u * u)), r + (1.0 - r) / u.powi(3))
    }

    /// Curvature over that at which it yields by a moment of the same measure beyond 1; infinite where it has no more to hold.
    fn bend(&self, moment: f64) -> f64 {
        if self.hardening == 0.0 {
            return if moment < 1.5 { (3.0 - 2.0 * moment).sqrt().recip() } else { f64::INFINITY };
        }
        let mut u = 1.0;
        for _ in 0..MOST {
            let (own, by) = self.moment(u);
            let step = (moment - own) / by;
            u += step;
            if step <= 1e-15 * u {
                break;
            }
        }
        u
    }

    /// Where a place of the strip lies among the stations: the one before it, and how far behind that.
    fn station(&self, from_clamp: f64) -> (usize, f64) {
        let at = (from_clamp / self.length).clamp(0.0, 1.0) * STATIONS as f64;
        let before = (at.floor() as usize).min(STATIONS - 1);
        (before, at - before as f64)
    }

    /// What a place remembers, and its derivative by the place.
    fn worn(&self, from_clamp: f64) -> (f64, f64) {
        let (before, behind) = self.station(from_clamp);
        let [a, b] = [before, before + 1].map(|k| self.worn.get(k).copied().unwrap_or(1.0));
        (a + behind * (b - a), (b - a) * STATIONS as f64 / self.length)
    }

    /// Curvature by a moment over EI at a place, and its derivatives by moment and place.
    fn curvature(&self, moment: f64, from_clamp: f64) -> [f64; 3] {
        let (worn, by_place) = self.worn(from_clamp);
        let (held, stiffness) = self.moment(worn);
        if moment <= held * self.yields {
            return [moment + (worn - held) * self.yields, 1.0, (1.0 - stiffness) * self.yields * by_place];
        }
        let bend = self.bend(moment / self.yields);
        [bend * self.yields, self.moment(bend).1.recip(), 0.0]
    }

    /// Bends `length` (m) of the strip as [`super::elastica::bend`] does.
    pub fn tip(&self, n: f64, f: f64, offset: f64, length: f64) -> Tip {
        let found = self.walk(n, f, offset, length, &mut |_, _| {});
        let [state, by_n, by_length] = found;
        let [end, ..] = self.rate(&found, n, f, 0.0);
        let by_length: [f64; 4] = std::array::from_fn(|k| by_length[k] + end[k]);
        Tip {
            slope: -state[0],
            at: [state[2], state[3]],
            by_n: [-by_n[0], by_n[2], by_n[3]],
            by_length: [-by_length[0], by_length[2], by_length[3]],
        }
    }

    /// The strip after it was bent so.
    #[must_use]
    pub fn after(&self, n: f64, f: f64, offset: f64, length: f64) -> Self {
        let bent = |(worn, moment): (&f64, f64)| match moment / self.yields {
            moment if moment > self.moment(*worn).0 => self.bend(moment),
            _ => *worn,
        };
        let worn: Vec<f64> = self.worn.iter().zip(self.moments(n, f, offset, length)).map(bent).collect();
        // Shared where nothing new has yielded: a path may have many points.
        if worn[..] == self.worn[..] { self.clone() } else { Self { worn: worn.into(), ..self.clone() } }
    }

    /// Moment over EI at each station.
    fn moments(&self, n: f64, f: f64, offset: f64, length: f64) -> Vec<f64> {
        let mut passed: Vec<(f64, f64)> = Vec::with_capacity(STATIONS + 1);
        self.walk(n, f, offset, length, &mut |from_clamp, state| passed.push((from_clamp, state[1])));
        passed.reverse();
        let at = |place: f64| -> f64 {
            if place > length {
                return 0.0;
            }
            let behind = passed.partition_point(|of| of.0 < place).clamp(1, passed.len() - 1);
            let ((a, from), (b, to)) = (passed[behind - 1], passed[behind]);
            from + (to - from) * ((place - a) / (b - a)).clamp(0.0, 1.0)
        };
        (0..=STATIONS).map(|k| at(self.length * k as f64 / STATIONS as f64)).collect()
    }

    /// The free end under the tool and without it.
    pub fn bent(&self, n: f64, f: f64, offset: f64, length: f64) -> Bent {
        let moments = self.moments(n, f, offset, length);
        let end = |moment: &dyn Fn(usize) -> f64| self.line(moment).last().map_or(0.0, |point| point[1]);
        let worst = self.worn.iter().fold(1.0, |most: f64, worn| most.max(*worn));
        Bent { under: end(&|k| moments.get(k).copied().unwrap_or(0.0)), left: end(&|_| 0.0), worst }
    }

    /// Depth (m) of the strip's surface, unloaded, at a distance along from the clamp; `None` beyond its end.
    pub fn depth(&self, along: f64, offset: f64) -> Option<f64> {
        let line = self.line(&|_| 0.0);
        let surface = line.iter().map(|[x, y, slope]| {
            let (sine, cosine) = slope.sin_cos();
            [x + offset * sine, y + offset - offset * cosine]
        });
        let mut last: Option<[f64; 2]> = None;
        for [x, y] in surface {
            if let Some([x0, y0]) = last
                && x >= along
                && x > x0
            {
                return Some(y0 + (y - y0) * (along - x0) / (x - x0));
            }
            last = Some([x, y]);
        }
        None
    }

    /// The centre line from the clamp by the moment over EI at each station: x, y and slope.
    fn line(&self, moment: &dyn Fn(usize) -> f64) -> Vec<[f64; 3]> {
        let h = self.length / STATIONS as f64;
        let bend = |k: usize| self.curvature(moment(k), self.length * k as f64 / STATIONS as f64)[0];
        let mut at = [0.0; 3];
        let mut line = vec![at];
        for k in 0..STATIONS {
            // Of a curvature linear between stations the slope is exact, and the line by Simpson's rule.
            let (from, to) = (bend(k), bend(k + 1));
            let slopes = [at[2], at[2] + h * (0.375 * from + 0.125 * to), at[2] + 0.5 * h * (from + to)];
            let mean = |of: fn(f64) -> f64| (of(slopes[0]) + 4.0 * of(slopes[1]) + of(slopes[2])) / 6.0;
            at = [at[0] + h * mean(f64::cos), at[1] + h * mean(f64::sin), slopes[2]];
            line.push(at);
        }
        line
    }

    /// Derivatives along the strip, from its tip to the clamp, of (psi, moment over EI, x, y), of the same by n, and by the
    /// length, at a distance from the clamp.
    fn rate(&self, [s, by_n, by_length]: &[[f64; 4]; 3], n: f64, f: f64, from_clamp: f64) -> [[f64; 4]; 3] {
        let (sine, cosine) = s[0].sin_cos();
        let across = cosine - f * sine;
        let across_by = |d: &[f64; 4]| -(sine + f * cosine) * d[0];
        let [curvature, by_moment, by_place] = self.curvature(s[1], from_clamp);
        let own = [-curvature, n * across, cosine, sine];
        let of_n = [-by_moment * by_n[1], across + n * across_by(by_n), -sine * by_n[0], cosine * by_n[0]];
        let bends = -by_moment * by_length[1] - by_place;
        let of_length = [bends, n * across_by(by_length), -sine * by_length[0], cosine * by_length[0]];
        [own, of_n, of_length]
    }

    /// Runge and Kutta's rule from the tip to the clamp; `each` sees the distance from the clamp and the state.
    fn walk(&self, n: f64, f: f64, offset: f64, length: f64, each: &mut dyn FnMut(f64, &[f64; 4])) -> [[f64; 4]; 3] {
        let mut state = [[0.0, f * n * offset, 0.0, 0.0], [0.0, f * offset, 0.0, 0.0], [0.0; 4]];
        let h = length / STATIONS as f64;
        let moved = |s: &[[f64; 4]; 3], k: &[[f64; 4]; 3], h: f64| -> [[f64; 4]; 3] {
            std::array::from_fn(|i| std::array::from_fn(|j| s[i][j] + h * k[i][j]))
        };
        each(length, &state[0]);
        for step in 0..STATIONS {
            let place = |part: f64| length - h * (step as f64 + part);
            let a = self.rate(&state, n, f, place(0.0));
            let b = self.rate(&moved(&state, &a, 0.5 * h), n, f, place(0.5));
            let c = self.rate(&moved(&state, &b, 0.5 * h), n, f, place(0.5));
            let d = self.rate(&moved(&state, &c, h), n, f, place(1.0));
            let mean = |i: usize, j: usize| a[i][j] + 2.0 * (b[i][j] + c[i][j]) + d[i][j];
            state = std::array::from_fn(|i| std::array::from_fn(|j| state[i][j] + h / 6.0 * mean(i, j)));
            each(place(1.0), &state[0]);
        }
        state
    }
}
