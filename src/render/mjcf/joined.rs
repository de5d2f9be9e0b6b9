//! Closed loops and couplings as equality constraints; springs between bodies, screws and sums of joints as tendons.

use super::scale::{TIME, is_held, stiffness};
use super::writer::{Writer, escaped};
use crate::description::raw::Meet;
use crate::description::robot::{Coupling, FrameIndex, Motion, Robot};

/// What the zeros of the joints that a coupling follows would add to it and do not, since the controller adds up what it commands.
fn commanded_zeros(robot: &Robot, coupling: &Coupling) -> f64 {
    fn passed_on(robot: &Robot, frame: FrameIndex) -> f64 {
        let own = &robot.frames[frame];
        let upstream = match own.motion {
            Motion::Coupling(which) if !robot.couplings[which].is_of_controller => {
                robot.couplings[which].terms.iter().map(|(factor, other)| factor * passed_on(robot, *other)).sum()
            }
            _ => 0.0,
        };
        upstream + own.offset
    }
    match coupling.is_of_controller {
        true => coupling.terms.iter().map(|(factor, other)| factor * passed_on(robot, *other)).sum(),
        false => 0.0,
    }
}

impl Writer<'_> {
    /// Loops and couplings.
    pub fn equalities(&mut self) {
        let robot = self.robot;
        if robot.loops.is_empty() && robot.couplings.is_empty() {
            return;
        }
        self.line(1, "<equality>");
        for own in &robot.loops {
            let name = escaped(&own.name);
            let kind = if own.meet == Meet::Origin { "connect" } else { "weld" };
            self.line(2, format!("<{kind} name=\"{name}\" site1=\"{name}.1\" site2=\"{name}.2\"/>"));
        }
        for coupling in &robot.couplings {
            let follower = self.name(coupling.joint);
            let zero = robot.frames[coupling.joint].offset - commanded_zeros(robot, coupling) + 0.0;
            if let [(factor, followed)] = coupling.terms[..] {
                let followed = self.name(followed);
                self.line(
                    2,
                    format!("<joint joint1=\"{follower}\" joint2=\"{followed}\" polycoef=\"{zero} {factor} 0 0 0\"/>"),
                );
            } else {
                self.line(2, format!("<tendon tendon1=\"{follower}.coupling\" polycoef=\"{zero} 0 0 0 0\"/>"));
            }
        }
        self.line(1, "</equality>");
    }

    /// Springs between bodies, screws, and sums of joints that a coupling keeps at zero.
    pub fn tendons(&mut self) {
        let robot = self.robot;
        let springs: Vec<_> = robot.elastic.springs.iter().filter(|spring| is_held(spring)).collect();
        let sums: Vec<_> = robot.couplings.iter().filter(|coupling| coupling.terms.len() != 1).collect();
        if springs.is_empty() && sums.is_empty() && robot.actuators.is_empty() {
            return;
        }
        self.line(1, "<tendon>");
        for spring in springs {
            let rate = stiffness(&spring.rate);
            let length = spring.free_length.unwrap_or_default();
            let how = format!(" stiffness=\"{rate}\" damping=\"{}\" springlength=\"{length}\"", 2.0 * TIME * rate);
            self.between_sites(&escaped(&spring.name), &how);
        }
        for screw in &robot.actuators {
            self.between_sites(&escaped(&screw.name), "");
        }
        for coupling in sums {
            self.line(2, format!("<fixed name=\"{}.coupling\">", self.name(coupling.joint)));
            self.line(3, format!("<joint joint=\"{}\" coef=\"1\"/>", self.name(coupling.joint)));
            for (factor, followed) in &coupling.terms {
                self.line(3, format!("<joint joint=\"{}\" coef=\"{}\"/>", self.name(*followed), -factor));
            }
            self.line(2, "</fixed>");
        }
        self.line(1, "</tendon>");
    }

    /// A tendon straight between the two sites of its name.
    fn between_sites(&mut self, name: &str, attributes: &str) {
        self.line(2, format!("<spatial name=\"{name}\"{attributes}>"));
        self.line(3, format!("<site site=\"{name}.1\"/><site site=\"{name}.2\"/>"));
        self.line(2, "</spatial>");
    }
}
