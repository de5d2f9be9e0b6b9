//! Scaling, radius, and the box they make with the bounds.

use nalgebra::DVector;

use super::bounds::Bounds;
use super::box_step::Region;
use super::linear::Step;

/// A step is taken when it achieves this part of what it promised.
const ACCEPTED: f64 = 1e-4;
/// Below this part the model is not to be trusted that far.
const POOR: f64 = 0.25;
/// Above this part it may be trusted farther.
pub(super) const GOOD: f64 = 0.75;

/// A start value is taken for a guess of a parameter's size: a change by all of it weighs at least this part of what it
/// weighs in the most influential parameter ...
const GUESS: f64 = 0.3;
/// ... unless that would make the parameter so many times more sluggish than its derivative makes it.
const GUESS_LIMIT: f64 = 1e8;

/// The set `|D p| <= radius`.
pub(super) struct TrustRegion {
    /// Diagonal of D (n), all positive.
    pub scale: Vec<f64>,
    /// Size, in units of the residual.
    pub radius: f64,
    /// Largest norm each column has had (n).
    largest: Vec<f64>,
}

impl TrustRegion {
    /// The region around the start, from the norm of each column (n) and of the residual there.
    ///
    /// The radius is `multiple` of the scaled parameters. Column norms alone do not bound a parameter whose column
    /// happens to be small at a bad start (an exponential that has died out at the first measurement), so its own size
    /// bounds its steps too. A parameter that starts at 0 offers no such guess; if all do, a
    /// change of the residual by its own size must serve.
    pub fn new(norms: &DVector<f64>, residual: f64, x: &[f64], multiple: f64) -> Self {
        let mut region = Self { scale: vec![1.0; x.len()], radius: multiple, largest: vec![0.0; x.len()] };
        region.rescale(norms);
        let size = region.size(x);
        if size > 0.0 {
            region.radius *= size;
            for ((largest, norm), x) in region.largest.iter_mut().zip(norms).zip(x) {
                if *x != 0.0 {
                    *largest = largest.max((GUESS * size / x.abs()).min(GUESS_LIMIT * norm));
                }
            }
            region.rescale(norms);
        } else if residual > 0.0 {
            region.radius *= residual;
        }
        region
    }

    /// Takes note of the column norms at a new iterate.
    ///
    /// The largest norm so far, not the current one: where a column fades (the flat end of an exponential) the current
    /// norm would let its parameter run away (Moré 1978, section 4). A column that was always zero has no scale; 1 will do.
    pub fn rescale(&mut self, norms: &DVector<f64>) {
        for ((scale, largest), norm) in self.scale.iter_mut().zip(&mut self.largest).zip(norms) {
            *largest = largest.max(*norm);
            *scale = if *largest > 0.0 { *largest } else { 1.0 };
        }
    }

    /// Scaled size of the parameters, `|D x|`.
    pub fn size(&self, x: &[f64]) -> f64 {
        x.iter().zip(&self.scale).map(|(x, d)| (x * d).powi(2)).sum::<f64>().sqrt()
    }

    /// Trust region and bounds as one box of the scaled step.
    pub fn region(&self, x: &[f64], bounds: &Bounds) -> Region {
        let side = |limits: &[f64]| {
            let scaled = x.iter().zip(limits).zip(&self.scale).map(|((x, limit), d)| (limit - x) * d);
            DVector::from_iterator(x.len(), scaled.map(|limit| limit.clamp(-self.radius, self.radius)))
        };
        Region { lower: side(&bounds.lower), upper: side(&bounds.upper) }
    }

    /// `x + p`, exactly on a bound where the step goes to one.
    pub fn apply(&self, x: &[f64], z: &DVector<f64>, bounds: &Bounds) -> Vec<f64> {
        let limits = bounds.lower.iter().zip(&bounds.upper);
        let moved = x.iter().zip(z).zip(&self.scale).zip(limits).map(|(((x, z), d), (&lower, &upper))| {
            if *z < 0.0 && *z <= (lower - x) * d {
                lower
            } else if *z > 0.0 && *z >= (upper - x) * d {
                upper
            } else {
                (x + z / d).max(lower).min(upper)
            }
        });
        moved.collect()
    }

    /// Whether a step with this gain (actual over promised reduction) is worth taking.
    pub fn accepts(gain: f64) -> bool {
        gain > ACCEPTED
    }

    /// Adapts the radius to a step that lowered the cost by `reduction`.
    pub fn adapt(&mut self, step: &Step, reduction: f64) {
        let gain = reduction / step.reduction;
        if gain < POOR {
            // The minimiser of the parabola through both costs and the slope, kept between a tenth and a half.
            let factor = if reduction < 0.0 { 0.5 * step.slope / (step.slope + reduction) } else { 0.5 };
            self.radius = factor.clamp(0.1, 0.5) * step.length.min(self.radius);
        } else if gain > GOOD {
            self.radius = self.radius.max(2.0 * step.length);
        }
    }

    /// The model has no value at the end of this step.
    pub fn retreat(&mut self, step: &Step) {
        self.radius = 0.25 * step.length.min(self.radius);
    }
}
