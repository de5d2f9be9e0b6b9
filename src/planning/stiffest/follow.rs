//! A posture carried along the path, and from one placement of the workpiece to the next.

use super::arm::{Arm, Posture};
use super::{Moved, Stop, Way};
use crate::prediction::SingleWorkspace;

impl Arm<'_> {
    /// The path from a posture at its first point on: each point from the posture of the one before.
    ///
    /// # Errors
    /// The index (in `points`) of the first that cannot be taken, and why.
    pub fn follow(
        &self,
        moved: Moved,
        points: &[usize],
        first: Posture,
        steps: [&[f64]; 2],
        work: &mut SingleWorkspace,
    ) -> Result<Way, (usize, Stop)> {
        let motion = moved.motion();
        let mut postures: Vec<Posture> = Vec::with_capacity(points.len());
        for (k, &index) in points.iter().enumerate() {
            let posture = match postures.last() {
                None => self.settle(index, &motion, first.clone(), steps[0], work),
                Some(last) => {
                    let next = self.near(index, &motion, last.joints.clone(), work).map_err(|why| (k, why))?;
                    self.settle(index, &motion, next, steps[1], work)
                }
            };
            postures.push(posture);
        }
        Ok(Way { moved, postures })
    }

    /// A way through points of the path, carried to another placement; none where that cannot be.
    pub fn carry(&self, way: &Way, moved: Moved, points: &[usize], work: &mut SingleWorkspace) -> Option<Way> {
        let motion = moved.motion();
        let steps = self.wanted.search.self_motions[2];
        let each = points.iter().zip(&way.postures).map(|(&index, posture)| {
            let found = self.near(index, &motion, posture.joints.clone(), work).ok()?;
            Some(self.settle(index, &motion, found, steps, work))
        });
        Some(Way { moved, postures: each.collect::<Option<Vec<Posture>>>()? })
    }
}
