//! Springs whose compliance depends on the configuration by fuzzy rules.

use super::Model;
use super::fault::Fault;
use crate::description::fuzzy::{Input, Rules, SpringRules};
use crate::diagnostic::Diagnostic;
use crate::parameter::{Group, Kind, Parameter, Slot};

/// Springs whose compliance depends on the configuration, in place of what is declared for them.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalSprings {
    /// Inputs of the rules.
    pub inputs: Vec<Input>,
    /// Each spring's parameter and rules; conclusions are compliances, m/N or rad/(N.m).
    pub springs: Vec<(Slot, Rules)>,
}

impl LocalSprings {
    /// Whether a parameter is a spring that rules can stand for: one that is computed with as a compliance.
    pub fn can_hold(parameter: &Parameter) -> bool {
        parameter.group == Group::Elastic && parameter.kind.is_compliance() && parameter.inverted
    }
}

/// Puts the fuzzy springs into a model, whose own values for them are then not used.
pub(super) fn put(model: &mut Model, declared: &SpringRules) -> Result<(), Vec<Fault>> {
    let (mut springs, mut faults) = (Vec::new(), Vec::new());
    for (name, rules) in &declared.springs {
        let slot = model.registry.slot(name).filter(|slot| LocalSprings::can_hold(&model.registry[*slot]));
        let Some(slot) = slot else {
            let known = model.registry.all().iter().filter(|of| LocalSprings::can_hold(of)).map(|of| of.name.as_str());
            let known: Vec<&str> = known.collect();
            let diagnostic =
                Diagnostic::error(format!("`{name}` is no spring of this description")).suggest(name, known);
            faults.push(Fault::new(&["fuzzy", "springs", name], diagnostic));
            continue;
        };
        let parameter = &mut model.registry.all_mut()[slot];
        parameter.free = false;
        let unit = declared.units[usize::from(parameter.kind == Kind::RotationalCompliance)];
        let conclusions = rules.conclusions.iter().map(|stiffness| 1.0 / (stiffness * unit)).collect();
        springs.push((slot, Rules { conclusions, ..rules.clone() }));
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    model.local_springs = Some(LocalSprings { inputs: declared.inputs.clone(), springs });
    Ok(())
}
