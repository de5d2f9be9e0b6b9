//! What else machines and instruments do, each by a unit: joints turn (rad), points are displaced (m).

use nalgebra::Vector3;

use super::situation::Situation;

/// A shape of its own.
#[derive(Debug, Clone)]
pub enum Odd {
    /// A joint gives only once its load is beyond a share of the greatest.
    DeadZone { variable: usize, half: f64 },
    /// A joint gives to one side up to a stop at a share of the greatest load.
    Stop { variable: usize, at: f64 },
    /// Two orders that beat against each other.
    Beat { variable: usize, orders: [f64; 2], phases: [f64; 2] },
    /// A tooth is damaged.
    Tooth { variable: usize, at: f64, width: f64 },
    /// A joint sticks on the side that it came from, the more so by where another one stands.
    Friction { variable: usize, other: usize, scale: f64 },
    /// A joint stops short by a share of its move, a little less of long ones.
    StopsShort { variable: usize, less: f64 },
    /// The foot settles after each move, as far as the machine was moved.
    Foot { along: Vector3<f64> },
    /// The instrument wanders, slowly more than fast: cycles over the campaign, phase, direction.
    Wander { waves: Vec<(f64, f64, Vector3<f64>)> },
    /// The instrument's circle is off its centre: errors across the line of sight, twice a turn.
    Circle { phase: f64 },
}

impl Odd {
    /// What a unit of it turns one joint by, rad: variable and angle.
    pub fn turns(&self, s: &Situation) -> Option<(usize, f64)> {
        Some(match *self {
            Self::DeadZone { variable, half } => {
                let x = s.share(variable, 1.0);
                (variable, x - x.clamp(-half, half))
            }
            Self::Stop { variable, at } => (variable, s.share(variable, 1.0).clamp(0.0, at)),
            Self::Beat { variable, orders, phases } => {
                let wave = |k: usize| (orders[k] * s.joints[variable] + phases[k]).cos();
                (variable, wave(0) + wave(1))
            }
            Self::Tooth { variable, at, width } => (variable, (-((s.joints[variable] - at) / width).powi(2)).exp()),
            Self::Friction { variable, other, scale } => {
                let stuck = (s.last_move[variable] / scale).tanh();
                (variable, stuck * (1.0 + 0.8 * (2.0 * s.q[other]).cos()))
            }
            Self::StopsShort { variable, less } => {
                let moved = s.last_move[variable];
                (variable, moved / (1.0 + less * moved.abs()))
            }
            _ => return None,
        })
    }

    /// What a unit of it displaces the machine by, base axes, given the last moves of the variables.
    pub fn pushes(&self, last_move: &[f64]) -> Option<Vector3<f64>> {
        let Self::Foot { along } = self else { return None };
        let moved = last_move.iter().map(|moved| moved * moved).sum::<f64>().sqrt();
        Some(along * (moved / (1.0 + moved)))
    }

    /// What a unit of it adds to what the instrument shows of a point, measurement frame.
    pub fn shows(&self, time: f64, seen: &Vector3<f64>) -> Option<Vector3<f64>> {
        match self {
            Self::Wander { waves } => {
                let turn = std::f64::consts::TAU;
                Some(waves.iter().map(|(cycles, phase, along)| along * (turn * cycles * time + phase).sin()).sum())
            }
            Self::Circle { phase } => {
                let azimuth = seen.y.atan2(seen.x);
                Some(Vector3::new(-seen.y, seen.x, 0.0) * (2.0 * azimuth + phase).sin())
            }
            _ => None,
        }
    }
}
