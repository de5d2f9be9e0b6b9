//! What a description leaves out: the catalogue of effects, one file each.
//!
//! An effect says where it can sit, which parameters it has, and what one unit of each changes in a reading: a joint
//! moves, a constant of the model changes, the measured point is displaced. Everything else - prediction, derivatives,
//! competition, simulation - follows from that. To first order in its parameters an effect of millimetres is exact to a
//! micrometre; what is not linear in an effect (an order, a torque scale, a time) is its *form*, of which it offers
//! several.
//!
//! An effect of one's own implements [`Effect`] and is handed to `diagnosis::diagnose` beside [`catalogue`]; see
//! `examples/own_effect.rs`.

mod actuator_compliance;
mod backlash;
mod base_compliance;
mod bearing_compliance;
mod frame_drift;
mod gear_ratio;
mod geometry;
mod gravity_compensator;
mod instrument_scale;
mod joint_compliance;
mod joint_coupling;
mod joint_offset;
mod joint_stiffening;
mod link_compliance;
mod link_weight;
mod outliers;
mod payload;
mod site;
mod thermal_expansion;
mod transmission_error;

pub use site::{Site, SiteKind, sites_of};

use nalgebra::Vector3;

use crate::description::raw::RawEffect;
use crate::model::Model;
use crate::parameter::Slot;

/// What one unit of a parameter changes in a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// A joint (by its variable) stands elsewhere than commanded, rad or m of the joint. Where a reading is the
    /// difference of two at one pose, it cancels.
    Joint(usize, f64),
    /// A joint gives way under load, rad or m: only what the applied wrench adds counts in a difference.
    Yield(usize, f64),
    /// A parameter of the model has another value in this reading, SI.
    Slot(Slot, f64),
    /// The measured point is displaced (m) and the tool turned (rad), measurement frame.
    Point(Vector3<f64>, Vector3<f64>),
}

/// What an effect may look at in a reading.
#[derive(Debug, Clone)]
pub struct Moment<'a> {
    /// The model.
    pub model: &'a Model,
    /// Actuated variables, rad or m.
    pub q: &'a [f64],
    /// Joint values by frame, rad or m.
    pub joints: &'a [f64],
    /// Load on the joint of each variable under own weight and the applied wrench, N.m or N.
    pub load: &'a [f64],
    /// The same under own weight alone.
    pub own_load: &'a [f64],
    /// Side of approach of each variable, +1 or -1; 0 where it is not known.
    pub side: &'a [f64],
    /// s from the start, where known.
    pub time: Option<f64>,
    /// Temperature of the reading, degC or K as given, where known; of a site where that is measured.
    pub temperature: Option<f64>,
    /// Measured point, measurement frame, m (of a deflection: where it is, not how far it moves).
    pub position: Vector3<f64>,
    /// Origin of the base in the measurement frame, m.
    pub base: Vector3<f64>,
    /// Displacement by the applied wrench alone, measurement frame, m.
    pub deflection: Vector3<f64>,
    /// The reading is the loaded position less the unloaded one.
    pub is_difference: bool,
}

/// What a campaign offers, for effects to choose their forms by.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Survey {
    /// Greatest load on the joint of each variable, N.m or N.
    pub greatest_load: Vec<f64>,
    /// Greatest load of own weight alone on the joint of each variable, N.m or N.
    pub greatest_own_load: Vec<f64>,
    /// Times of the configurations in order, s; empty where not known.
    pub times: Vec<f64>,
    /// Whether temperatures are known.
    pub temperatures: bool,
    /// Variables whose side of approach is known and not always the same.
    pub sides: Vec<bool>,
    /// Whether a wrench is applied.
    pub loaded: bool,
    /// Readings are differences.
    pub is_difference: bool,
}

/// A form of an effect: what is not linear in it, by name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form {
    /// What the number is; empty where the effect has but one form.
    pub symbol: &'static str,
    /// Its value, SI.
    pub value: f64,
    /// Whether values between those offered make sense.
    pub continuous: bool,
}

impl Form {
    /// The only form.
    pub const ONLY: Self = Self { symbol: "", value: 0.0, continuous: false };
}

/// A parameter of an effect; zero is absent.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectParameter {
    /// Symbol.
    pub symbol: String,
    /// SI unit.
    pub unit: &'static str,
    /// Common size, one sigma, SI.
    pub scale: f64,
    /// Whether it cannot be negative.
    pub is_positive: bool,
}

/// An unmodelled effect.
pub trait Effect: Send + Sync {
    /// Name in the catalogue.
    fn name(&self) -> &'static str;
    /// Where it can sit.
    fn sits_at(&self) -> SiteKind;
    /// What it looks like in the residuals, in words.
    fn signature(&self) -> &'static str;
    /// What to do on the machine.
    fn remedy(&self) -> &'static str;
    /// Its sites on a robot.
    fn sites(&self, model: &Model) -> Vec<Site> {
        sites_of(model, self.sits_at())
    }
    /// Whether it is the measurement that is wrong, and not the robot: nothing that a command could correct.
    fn is_of_the_measurement(&self) -> bool {
        self.sits_at() == SiteKind::Instrument
    }
    /// Parameters of the model that it frees, where it is nothing but constants off nominal.
    fn constants(&self, _model: &Model, _site: &Site, _form: &Form) -> Vec<Slot> {
        Vec::new()
    }
    /// Forms in which it may come, given what the campaign offers; none where it cannot show.
    fn forms(&self, _model: &Model, _site: &Site, _survey: &Survey) -> Vec<Form> {
        vec![Form::ONLY]
    }
    /// Symbols of its forms.
    fn form_symbols(&self) -> &'static [&'static str] {
        &[]
    }
    /// Parameters of a form; by default its [`Effect::constants`].
    fn parameters(&self, model: &Model, site: &Site, form: &Form) -> Vec<EffectParameter> {
        of_slots(model, &self.constants(model, site, form))
    }
    /// What one unit of each parameter changes in a reading: parameter, change.
    fn changes(&self, _site: &Site, _form: &Form, _moment: &Moment, _out: &mut Vec<(usize, Change)>) {}
}

/// All effects of the catalogue.
pub fn catalogue() -> Vec<&'static dyn Effect> {
    vec![
        &geometry::Geometry,
        &joint_offset::JointOffset,
        &gear_ratio::GearRatio,
        &transmission_error::TransmissionError,
        &joint_coupling::JointCoupling,
        &backlash::Backlash,
        &joint_compliance::JointCompliance,
        &joint_stiffening::JointStiffening,
        &bearing_compliance::BearingCompliance,
        &link_compliance::LinkCompliance,
        &actuator_compliance::ActuatorCompliance,
        &gravity_compensator::GravityCompensator,
        &link_weight::LinkWeight,
        &payload::Payload,
        &base_compliance::BaseCompliance,
        &thermal_expansion::ThermalExpansion,
        &frame_drift::FrameDrift,
        &instrument_scale::InstrumentScale,
        &outliers::Outliers,
    ]
}

/// An effect of the catalogue by name.
pub fn by_name(name: &str) -> Option<&'static dyn Effect> {
    catalogue().into_iter().find(|effect| effect.name() == name)
}

/// What is wrong with an effect that a description declares: its name, its site on this robot or a parameter is not
/// known. What, and the remedy.
///
/// # Errors
/// If so.
pub fn fault(model: &Model, entry: &RawEffect) -> Result<(), (String, String)> {
    let name = entry.effect.as_deref().unwrap_or_default();
    let Some(effect) = by_name(name) else {
        let known: Vec<&str> = catalogue().iter().map(|effect| effect.name()).collect();
        return Err((
            format!("unknown effect `{name}`"),
            format!(
                "the catalogue has {}; an effect of one's own lives in the program that declares it",
                known.join(", ")
            ),
        ));
    };
    let site = entry.site.as_deref().unwrap_or_default();
    let sites = effect.sites(model);
    let Some(at) = sites.iter().find(|known| known.name == site) else {
        let known: Vec<&str> = sites.iter().map(|site| site.name.as_str()).collect();
        let known = if known.is_empty() { "nowhere on this robot".into() } else { known.join(", ") };
        return Err((format!("`{name}` cannot sit at `{site}`"), format!("it can sit at: {known}")));
    };
    let mut symbols: Vec<String> = effect.form_symbols().iter().map(ToString::to_string).collect();
    symbols.extend(effect.parameters(model, at, &form_of(effect, entry)).into_iter().map(|p| p.symbol));
    match entry.parameters.keys().find(|key| !symbols.contains(key)) {
        Some(key) if !symbols.is_empty() => {
            Err((format!("`{name}` has no parameter `{key}`"), format!("its parameters (SI): {}", symbols.join(", "))))
        }
        _ => Ok(()),
    }
}

/// What is doubtful about an effect that a description declares and that has no [`fault`]: that it has no amount, or one
/// that makes a compliance or another parameter negative that cannot be. What, and the remedy.
pub fn doubt(model: &Model, entry: &RawEffect) -> Option<(String, String)> {
    let name = entry.effect.as_deref().unwrap_or_default();
    let effect = by_name(name)?;
    let at = effect.sites(model).into_iter().find(|known| entry.site.as_deref() == Some(known.name.as_str()))?;
    let parameters = effect.parameters(model, &at, &form_of(effect, entry));
    let given = |parameter: &EffectParameter| entry.parameters.get(&parameter.symbol).copied();
    if !parameters.is_empty() && parameters.iter().all(|parameter| given(parameter).is_none()) {
        let symbols: Vec<&str> = parameters.iter().map(|parameter| parameter.symbol.as_str()).collect();
        let message = format!("`{name}` has no amount, and changes nothing");
        return Some((message, format!("give its parameters (SI): {}", symbols.join(", "))));
    }
    parameters.iter().filter(|parameter| parameter.is_positive).find_map(|parameter| {
        let amount = given(parameter)?;
        let declared = model.registry.slot(&parameter.symbol).map_or(0.0, |slot| model.registry[slot].nominal);
        (declared + amount < 0.0).then(|| {
            let (symbol, unit) = (&parameter.symbol, parameter.unit);
            (
                format!("`{symbol}: {amount:e}` makes it {:e} {unit}, and it cannot be below 0", declared + amount),
                format!("the amount adds to what the description says, {declared:e} {unit}"),
            )
        })
    })
}

/// The form in which an effect is declared.
pub fn form_of(effect: &dyn Effect, entry: &RawEffect) -> Form {
    effect
        .form_symbols()
        .iter()
        .find_map(|&symbol| entry.parameters.get(symbol).map(|&value| Form { symbol, value, continuous: false }))
        .unwrap_or(Form::ONLY)
}

/// Parameters of an effect that is nothing but constants.
pub(crate) fn of_slots(model: &Model, slots: &[Slot]) -> Vec<EffectParameter> {
    slots
        .iter()
        .map(|&slot| {
            let parameter = &model.registry[slot];
            EffectParameter {
                symbol: parameter.name.clone(),
                unit: parameter.kind.unit(),
                scale: parameter.tolerance,
                is_positive: parameter.bounds[0] == 0.0,
            }
        })
        .collect()
}

/// Sites at which the model has the constants of an effect.
pub(crate) fn sites_with_constants(effect: &dyn Effect, model: &Model) -> Vec<Site> {
    let all = sites_of(model, effect.sits_at()).into_iter();
    all.filter(|site| !effect.constants(model, site, &Form::ONLY).is_empty()).collect()
}

/// Slots of names that exist.
pub(crate) fn named(model: &Model, names: impl IntoIterator<Item = String>) -> Vec<Slot> {
    names.into_iter().filter_map(|name| model.registry.slot(&name)).collect()
}
