//! Order in which joints are evaluated, and the plan of each closed loop.

use super::fault::Fault;
use super::{Frame, Model};
use crate::description::raw::{LoopKind, Meet};
use crate::description::robot::{FrameIndex, Loop, Motion, Robot, branches};
use crate::diagnostic::Diagnostic;

/// One step of the evaluation of joints that have no variable of their own.
#[derive(Debug, Clone)]
pub enum Stage {
    /// The joint of an actuator.
    Actuator(usize),
    /// A joint that follows others: coupling, joint.
    Coupling(usize, FrameIndex),
    /// The passive joints of loops that share some.
    Loops(LoopGroup),
}

/// Loops that share passive joints and are closed together.
#[derive(Debug, Clone)]
pub struct LoopGroup {
    /// The loops.
    pub loops: Vec<LoopPlan>,
    /// Passive joints to be found.
    pub unknowns: Vec<FrameIndex>,
    /// Other moving joints of the loops.
    pub inputs: Vec<FrameIndex>,
    /// Rough values of `unknowns` (joint variables), from the declared branch.
    pub guess: Vec<f64>,
    /// Values of all variables at which the branch was read.
    pub at: Vec<f64>,
    /// Loops with more equations than unknowns are closed in the least-squares sense, up to this gap, m; 0 otherwise.
    pub gap: f64,
    /// Number of closure equations.
    pub equations: usize,
}

/// One loop: its two branches from the common ancestor to the frames that meet.
#[derive(Debug, Clone)]
pub struct LoopPlan {
    /// Name.
    pub name: String,
    /// In the plane or in space.
    pub kind: LoopKind,
    /// What coincides.
    pub meet: Meet,
    /// Frames of the two branches.
    pub branches: [Vec<FrameIndex>; 2],
    /// First equation of this loop in its group.
    pub row: usize,
}

impl LoopPlan {
    /// Number of closure equations.
    pub fn equations(&self) -> usize {
        match (self.kind, self.meet) {
            (LoopKind::Planar, Meet::Frame) => 3,
            (LoopKind::Planar, Meet::Origin) => 2,
            (LoopKind::Spatial, Meet::Frame) => 6,
            (LoopKind::Spatial, Meet::Origin) => 3,
        }
    }
}

/// Orders everything that is not directly driven.
pub fn stages(model: &Model, robot: &Robot) -> Result<Vec<Stage>, Vec<Fault>> {
    let mut faults = Vec::new();
    let mut waiting: Vec<(Stage, Vec<FrameIndex>, Vec<FrameIndex>)> = Vec::new(); // stage, needs, gives
    for (index, frame) in model.frames.iter().enumerate() {
        match frame.motion {
            Motion::Actuator(which) => waiting.push((Stage::Actuator(which), vec![], vec![index])),
            Motion::Coupling(which) => {
                let needs = model.couplings[which].iter().map(|term| term.1).collect();
                waiting.push((Stage::Coupling(which, index), needs, vec![index]));
            }
            _ => {}
        }
    }
    for group in groups(robot) {
        let group = plan_group(model, robot, &group, &mut faults);
        let (needs, gives) = (group.inputs.clone(), group.unknowns.clone());
        waiting.push((Stage::Loops(group), needs, gives));
    }
    let direct = |frame: &Frame| matches!(frame.motion, Motion::Variable { .. } | Motion::Fixed);
    let mut known: Vec<bool> = model.frames.iter().map(direct).collect();
    let mut ordered = Vec::new();
    while !waiting.is_empty() {
        let (ready, rest): (Vec<_>, Vec<_>) =
            waiting.into_iter().partition(|(_, needs, _)| needs.iter().all(|&i| known[i]));
        if ready.is_empty() {
            let names: Vec<&str> =
                rest.iter().flat_map(|(_, _, gives)| gives).map(|&i| model.frames[i].name.as_str()).collect();
            let diagnostic = Diagnostic::error(format!(
                "joints {} depend on each other through loops and couplings in a circle",
                names.join(", ")
            ))
            .remedy("a joint inside a loop can follow only joints that the loop does not move");
            faults.push(Fault::new(&["loops"], diagnostic));
            break;
        }
        for (stage, _, gives) in ready {
            gives.iter().for_each(|&joint| known[joint] = true);
            ordered.push(stage);
        }
        waiting = rest;
    }
    if faults.is_empty() { Ok(ordered) } else { Err(faults) }
}

/// Gap of an over-constrained loop whose description says nothing of it, m (or rad): constants off by their tolerances leave
/// some, and what is described wrongly mostly more.
const OVER_CONSTRAINED: f64 = 0.01;

/// Loops joined wherever they share a passive joint.
fn groups(robot: &Robot) -> Vec<Vec<&Loop>> {
    let passive = |closed: &Loop| -> Vec<FrameIndex> {
        branches(&robot.frames, closed.frames[0], closed.frames[1])
            .concat()
            .into_iter()
            .filter(|&i| robot.frames[i].motion == Motion::Passive)
            .collect()
    };
    let mut groups: Vec<(Vec<&Loop>, Vec<FrameIndex>)> = Vec::new();
    for closed in &robot.loops {
        let own = passive(closed);
        let (touching, apart): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|(_, joints)| joints.iter().any(|joint| own.contains(joint)));
        let mut merged = (vec![], own);
        for (loops, joints) in touching {
            merged.0.extend(loops);
            merged.1.extend(joints);
        }
        merged.0.push(closed);
        groups = apart;
        groups.push(merged);
    }
    groups.into_iter().map(|(loops, _)| loops).collect()
}

fn plan_group(model: &Model, robot: &Robot, loops: &[&Loop], faults: &mut Vec<Fault>) -> LoopGroup {
    let mut plans = Vec::new();
    let mut members: Vec<FrameIndex> = Vec::new();
    let mut equations = 0;
    for closed in loops {
        let branches = branches(&robot.frames, closed.frames[0], closed.frames[1]);
        members.extend(branches.concat());
        let plan =
            LoopPlan { name: closed.name.clone(), kind: closed.kind, meet: closed.meet, branches, row: equations };
        equations += plan.equations();
        plans.push(plan);
    }
    members.sort_unstable();
    members.dedup();
    members.retain(|&i| model.frames[i].moves());
    let (unknowns, inputs): (Vec<FrameIndex>, Vec<FrameIndex>) =
        members.into_iter().partition(|&i| model.frames[i].motion == Motion::Passive);
    let declared = loops.iter().filter_map(|closed| closed.gap).reduce(f64::max);
    let gap = declared.unwrap_or(if equations > unknowns.len() { OVER_CONSTRAINED } else { 0.0 });
    if unknowns.len() > equations {
        let names: Vec<&str> = unknowns.iter().map(|&i| model.frames[i].name.as_str()).collect();
        let of: Vec<&str> = loops.iter().map(|closed| closed.name.as_str()).collect();
        let diagnostic = Diagnostic::error(format!(
            "loop {}: {} passive joints ({}) but only {equations} closure equations, so the loop can move by itself",
            of.join(", "),
            unknowns.len(),
            names.join(", ")
        ))
        .remedy("give a variable to one of the joints, or let `meet` be `frame`");
        // Loops that close together are reported at the first of them.
        let path: Vec<&str> = std::iter::once("loops").chain(of.first().copied()).collect();
        faults.push(Fault::new(&path, diagnostic));
    }
    let branch_value = |joint: FrameIndex| {
        loops.iter().flat_map(|closed| &closed.branch).find(|(i, _)| *i == joint).map_or(0.0, |b| b.1)
    };
    let guess = unknowns.iter().map(|&joint| branch_value(joint)).collect();
    let mut at = model.middle();
    for (variable, value) in loops.iter().flat_map(|closed| &closed.at) {
        at[*variable] = *value;
    }
    LoopGroup { loops: plans, unknowns, inputs, guess, at, gap, equations }
}
