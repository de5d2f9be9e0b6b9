//! The elastica: a thin strip bent in its plane as far as one likes, inextensible, bending moment in proportion to curvature.
//!
//! Seen from its loaded tip the strip obeys psi'' = -n (cos psi - f sin psi), counted along the strip towards the clamp,
//! with psi the angle against the tangent at the tip, n = N/EI the force across the tip and f n the force along it
//! (Euler 1744; Love 1927, sec. 262). Integrated by Runge and Kutta's rule of fourth order, its derivative by n along with it.

/// Steps of the integration: the error at the greatest bends of the published tables is below 1e-8 of the length.
const STEPS: usize = 100;

/// A strip seen from its loaded tip; x along the tangent there, away from the clamp, y towards where it is pushed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tip {
    /// Slope of the tip against the clamp, rad.
    pub slope: f64,
    /// The tip from the clamp, m, axes of the tip.
    pub at: [f64; 2],
    /// Derivatives of slope and of `at` by n (1/m2).
    pub by_n: [f64; 3],
    /// Derivatives of slope and of `at` by the length.
    pub by_length: [f64; 3],
}

/// Bends `length` (m) of a strip by a force across its tip of `n` times its bending rigidity (1/m2), one along it of `f`
/// times as much (positive away from the clamp), and a moment of the latter on the lever `offset` (m).
pub fn bend(n: f64, f: f64, offset: f64, length: f64) -> Tip {
    // psi, kappa = slope's change towards the tip, x, y, and the same by n.
    let mut state = [0.0, f * n * offset, 0.0, 0.0, 0.0, f * offset, 0.0, 0.0];
    let rate = |s: &[f64; 8]| -> [f64; 8] {
        let (sine, cosine) = s[0].sin_cos();
        let across = cosine - f * sine;
        let across_by = -(sine + f * cosine) * s[4];
        [-s[1], n * across, cosine, sine, -s[5], across + n * across_by, -sine * s[4], cosine * s[4]]
    };
    let h = length / STEPS as f64;
    let moved = |s: &[f64; 8], k: &[f64; 8], h: f64| -> [f64; 8] { std::array::from_fn(|i| s[i] + h * k[i]) };
    for _ in 0..STEPS {
        let a = rate(&state);
        let b = rate(&moved(&state, &a, 0.5 * h));
        let c = rate(&moved(&state, &b, 0.5 * h));
        let d = rate(&moved(&state, &c, h));
        state = std::array::from_fn(|i| state[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
    }
    let end = rate(&state);
    Tip {
        slope: -state[0],
        at: [state[2], state[3]],
        by_n: [-state[4], state[6], state[7]],
        by_length: [-end[0], end[2], end[3]],
    }
}
