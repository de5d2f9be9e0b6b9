//! The one place where an entry of `effects:` is resolved against a robot and its catalogue, validated, and switched on.
//!
//! Amounts are SI. They become parameters of the registry, named `effect@site.symbol`; those of an effect that is nothing
//! but constants of the model shift these constants instead.

use indexmap::IndexMap;

use super::site::{Site, SiteKind};
use super::tags::{as_curve, named_choices, with_curve};
use super::{Nonlinear, NonlinearParameter, NonlinearValue};
use crate::description::raw::{JointKind, RawAmount, RawCurve, RawEffect};
use crate::description::robot::{FrameIndex, Motion};
use crate::diagnostic::{Diagnostic, nearest};
use crate::math::distinct;
use crate::model::{Actuator, Effect, EffectEntry, EffectParameter, Family, Fault, Frame, Marker, Model, SwitchedOn};
use crate::parameter::{Group, Kind, Parameter, Slot};

/// Amounts of effects beyond so many times their usual size are doubted: 0.3 rad and 0.1 m, between which and a machine that still works
/// there is room. A judgement.
const BEYOND: f64 = 1e3;

impl EffectEntry {
    /// As it is written into a description.
    pub fn raw(&self, model: &Model) -> RawEffect {
        let amounts = self.amounts.iter().map(|(symbol, value)| (symbol.clone(), RawAmount::Number(*value)));
        let nonlinear = self.nonlinear.written(&model.coordinate_names());
        as_curve(RawEffect {
            effect: Some(self.effect.name().into()),
            site: Some(self.site.name.clone()),
            parameters: amounts.chain(nonlinear.into_iter().map(|(name, _, value)| (name.into(), value))).collect(),
            ..RawEffect::default()
        })
    }

    /// A warning where the entry has no amount, or one that makes a parameter negative that cannot be.
    pub fn doubt(&self, model: &Model) -> Option<Diagnostic> {
        let parameters = self.effect.parameters(model, &self.site, &self.nonlinear);
        if !parameters.is_empty() && self.amounts.is_empty() {
            let symbols: Vec<String> = parameters.iter().map(|parameter| format!("{}: ..", parameter.symbol)).collect();
            let message = format!("`{}` has no amount, and changes nothing", self.effect.name());
            return Some(
                Diagnostic::warning(message).remedy(format!("add `parameters: {{{}}}` (SI)", symbols.join(", "))),
            );
        }
        let is_constants = !self.effect.constants(model, &self.site, &self.nonlinear).is_empty();
        let great = parameters.iter().filter(|_| !is_constants).find_map(|parameter| {
            let (symbol, unit, scale) = (&parameter.symbol, parameter.unit, parameter.scale);
            let amount = *self.amounts.get(symbol)?;
            (amount.abs() > BEYOND * scale).then(|| {
                Diagnostic::warning(format!(
                    "`{symbol}: {amount:.3e}` of `{}` is {:.0e} times what such an effect usually is ({scale:.0e} {unit})",
                    self.effect.name(),
                    amount.abs() / scale
                ))
                .remedy("amounts of effects are SI, whatever `units:` says: rad, m, 1/K, rad/(N.m)")
            })
        });
        if great.is_some() {
            return great;
        }
        parameters.iter().filter(|parameter| parameter.is_positive).find_map(|parameter| {
            let (symbol, unit, amount) = (&parameter.symbol, parameter.unit, *self.amounts.get(&parameter.symbol)?);
            let declared = model.registry.slot(symbol).map_or(0.0, |slot| model.registry[slot].nominal);
            (declared + amount < 0.0).then(|| {
                let sum = declared + amount;
                Diagnostic::warning(format!("`{symbol}: {amount:e}` makes it {sum:e} {unit}, and it cannot be below 0"))
                    .remedy(format!("the amount adds to what the description says, {declared:e} {unit}"))
            })
        })
    }
}

impl Model {
    /// Sites of a kind on this robot.
    pub fn sites(&self, kind: SiteKind) -> Vec<Site> {
        let site = |name: String, frame: FrameIndex| Site {
            name,
            kind,
            frame,
            coordinate: None,
            actuator: None,
            marker: None,
        };
        let frames = || self.frames.iter().enumerate().skip(1);
        match kind {
            SiteKind::Frame => frames().map(|(index, frame)| site(format!("frame:{}", frame.name), index)).collect(),
            SiteKind::Joint => {
                let mut sites = self.joints_moved_by(|_| true);
                sites.retain(|site| site.coordinate.is_some());
                sites
            }
            SiteKind::Joints => vec![site("joints".into(), 0)],
            SiteKind::Link => frames()
                .filter(|(_, frame)| frame.joint != JointKind::Fixed)
                .map(|(index, frame)| site(format!("link:{}", frame.name), index))
                .collect(),
            SiteKind::Actuator => {
                let of = |(k, actuator): (usize, &Actuator)| Site {
                    coordinate: Some(actuator.variable),
                    actuator: Some(k),
                    ..site(format!("actuator:{}", actuator.name), actuator.joint)
                };
                self.actuators.iter().enumerate().map(of).collect()
            }
            SiteKind::Base => vec![site("base".into(), 0)],
            SiteKind::Tool => vec![site("tool".into(), self.tool.0)],
            SiteKind::Marker => {
                let of = |(k, marker): (usize, &Marker)| Site {
                    marker: Some(k),
                    ..site(format!("marker:{}", marker.name), marker.frame)
                };
                self.markers.iter().enumerate().map(of).collect()
            }
            SiteKind::Instrument => vec![site("instrument".into(), 0)],
        }
    }

    /// Sites at the joints that move in a way which is accepted, but for those that the controller couples: nothing drives them.
    pub fn joints_moved_by(&self, accepted: impl Fn(Motion) -> bool) -> Vec<Site> {
        let is_driven = |motion| !matches!(motion, Motion::Coupling(which) if self.coupled_by_controller[which]);
        let joints = self.frames.iter().enumerate().skip(1);
        let joints = joints.filter(|(_, frame)| frame.moves() && accepted(frame.motion) && is_driven(frame.motion));
        let site = |(index, frame): (FrameIndex, &Frame)| Site {
            name: format!("joint:{}", frame.name),
            kind: SiteKind::Joint,
            frame: index,
            coordinate: self.coordinate_of(index),
            actuator: None,
            marker: None,
        };
        joints.map(site).collect()
    }

    /// The sites at which this robot has the constants of an effect; of joints, those that a variable moves.
    pub fn sites_with_constants(&self, effect: &dyn Effect) -> Vec<Site> {
        let mut sites = self.sites(effect.sits_at());
        sites.retain(|site| !effect.constants(self, site, &Nonlinear::default()).is_empty());
        sites
    }

    /// Slots of the names that this robot has.
    pub fn slots_named(&self, names: impl IntoIterator<Item = String>) -> Vec<Slot> {
        names.into_iter().filter_map(|name| self.registry.slot(&name)).collect()
    }

    /// Names of the actuated variables.
    pub fn variable_names(&self) -> Vec<&str> {
        self.variables.iter().map(|variable| variable.name.as_str()).collect()
    }

    /// Resolves an entry of `effects:` against this robot and its catalogue; what versions up to 0.1 wrote is read too.
    ///
    /// # Errors
    /// An unknown effect, site or parameter, or a value that cannot be; the path is relative to the entry.
    pub fn resolve_effect(&self, raw: &RawEffect) -> Result<EffectEntry, Fault> {
        if let Some(RawCurve { at, amount }) = &raw.curve
            && at.len() != amount.len()
        {
            let message = format!("a curve with {} amounts at {} values", amount.len(), at.len());
            let diagnostic = Diagnostic::error(message).remedy("give one of `amount` for each of `at`");
            return Err(Fault::new(&["curve"], diagnostic));
        }
        let raw = &with_curve(&named_choices(raw));
        let lacks = |message: String| Fault::new(&[], Diagnostic::error(message));
        let name = raw.effect.as_deref().ok_or_else(|| lacks("an effect lacks its name, `effect`".into()))?;
        let Some(effect) = self.catalogue.get(name) else {
            let diagnostic = Diagnostic::error(format!("unknown effect `{name}`"));
            return Err(Fault::new(&["effect"], diagnostic.suggest(name, self.catalogue.names())));
        };
        if effect.family(&Nonlinear::default()) == Family::Gross {
            let diagnostic = Diagnostic::error(format!("`{name}` are of single readings, and nothing of a robot"));
            return Err(Fault::new(&["effect"], diagnostic.remedy("leave the entry out; `diagnose` finds them")));
        }
        let at = raw.site.as_deref().ok_or_else(|| lacks(format!("effect `{name}` lacks its `site`")))?;
        let sites = effect.sites(self);
        let Some(site) = sites.iter().find(|known| known.name == at) else {
            return Err(Fault::new(&["site"], self.unknown_site(effect.as_ref(), at, &sites)));
        };
        let (nonlinear, amounts) = self.stated(effect.as_ref(), site, &raw.parameters)?;
        Ok(EffectEntry { effect: effect.clone(), site: site.clone(), nonlinear, amounts })
    }

    /// Why an effect cannot sit at a site, its `sites` being others.
    fn unknown_site(&self, effect: &dyn Effect, at: &str, sites: &[Site]) -> Diagnostic {
        let (kind, owner) = at.split_once(':').unwrap_or((at, ""));
        let cannot = Diagnostic::error(format!("effect `{}` cannot sit at `{at}`", effect.name()));
        let own = std::iter::once(effect.sits_at()).chain(sites.iter().map(|site| site.kind));
        let written: Vec<&str> = distinct(own.map(SiteKind::written));
        if written.iter().all(|written| written.split(':').next() != Some(kind)) {
            let written: Vec<String> = written.iter().map(|written| format!("`{written}`")).collect();
            return cannot.remedy(format!("write {}", written.join(" or ")));
        }
        let (what, owners): (_, Vec<&str>) = match effect.sits_at() {
            SiteKind::Actuator => ("actuator", self.actuators.iter().map(|actuator| actuator.name.as_str()).collect()),
            SiteKind::Marker => ("marker", self.markers.iter().map(|marker| marker.name.as_str()).collect()),
            _ => ("frame", self.frames.iter().skip(1).map(|frame| frame.name.as_str()).collect()),
        };
        if at.contains(':') && !owners.contains(&owner) {
            return Diagnostic::error(format!("unknown {what} `{owner}`")).suggest(owner, owners);
        }
        let known: Vec<&str> = sites.iter().map(|site| site.name.as_str()).collect();
        let known = if known.is_empty() { "nowhere on this robot".into() } else { known.join(", ") };
        cannot.remedy(format!("it can sit at: {known}"))
    }

    /// Nonlinear values that an entry states, or their defaults.
    fn stated_nonlinear(
        &self,
        effect: &dyn Effect,
        site: &Site,
        given: &IndexMap<String, RawAmount>,
    ) -> Result<Vec<(&'static NonlinearParameter, NonlinearValue)>, Fault> {
        let name = effect.name();
        let mut values: Vec<(&'static NonlinearParameter, NonlinearValue)> = Vec::new();
        let mut faults = Vec::new();
        for parameter in effect.nonlinear_parameters() {
            let chosen = |(other, word): (&str, &'static str)| {
                values.iter().any(|(known, value)| known.name == other && *value == NonlinearValue::Choice(word))
            };
            if !parameter.only_with.is_none_or(chosen) {
                continue;
            }
            match (given.get(parameter.name), &parameter.default) {
                (Some(stated), _) => match parameter.read(stated, &self.coordinate_names()) {
                    Ok(value) => values.push((parameter, value)),
                    Err(remedy) => {
                        let message = format!("`{}: {stated}` of `{name}`", parameter.name);
                        let diagnostic = Diagnostic::error(message).remedy(remedy);
                        faults.push(Fault::new(&["parameters", parameter.name], diagnostic));
                    }
                },
                (None, Some(default)) => values.push((parameter, default.clone())),
                (None, None) => {
                    let message = format!("`{name}` lacks `{}`", parameter.name);
                    let diagnostic = Diagnostic::error(message).remedy(format!("give {}", parameter.meaning));
                    faults.push(Fault::new(&["parameters"], diagnostic));
                }
            }
        }
        if faults.is_empty() {
            return Ok(values);
        }
        faults.extend(self.unknown_amounts(effect, site, given));
        Fault::of_all(faults).map_or(Ok(values), Err)
    }

    /// Keys of an entry that no value of its nonlinear parameters would make known. Where what it has depends on those, as the amounts of
    /// a curve on its points, only keys that read like one of them.
    fn unknown_amounts(&self, effect: &dyn Effect, site: &Site, given: &IndexMap<String, RawAmount>) -> Vec<Fault> {
        let parameters = effect.parameters(self, site, &Nonlinear::default());
        let nonlinear = effect.nonlinear_parameters().into_iter().map(|parameter| parameter.name);
        let known: Vec<&str> = nonlinear.chain(parameters.iter().map(|parameter| parameter.symbol.as_str())).collect();
        // Of a series, as `cos2`, how many there are is such a value.
        let stem = |name: &str| name.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned();
        let is_of_series = |key: &str| known.iter().any(|known| stem(key) != key && stem(known) == stem(key));
        let unknown = given.keys().filter(|key| !known.contains(&key.as_str()) && !is_of_series(key));
        let is_certain = |key: &&String| !parameters.is_empty() || nearest(key, known.iter().copied()).is_some();
        let fault = |key: &String| {
            let diagnostic = Diagnostic::error(format!("`{}` has no parameter `{key}`", effect.name()));
            Fault::new(&["parameters", key], diagnostic.suggest(key, known.iter().copied()))
        };
        unknown.filter(is_certain).map(fault).collect()
    }

    /// Nonlinear values and amounts that an entry states, all known and possible.
    fn stated(
        &self,
        effect: &dyn Effect,
        site: &Site,
        given: &IndexMap<String, RawAmount>,
    ) -> Result<(Nonlinear, IndexMap<String, f64>), Fault> {
        let name = effect.name();
        let fault = |key: &str, message: String, remedy: String| {
            Fault::new(&["parameters", key], Diagnostic::error(message).remedy(remedy))
        };
        let finite = |value: &RawAmount| match value {
            RawAmount::Number(value) => value.is_finite(),
            RawAmount::Numbers(values) => values.iter().all(|value| value.is_finite()),
            RawAmount::Name(_) => true,
        };
        if let Some((key, value)) = given.iter().find(|(_, value)| !finite(value)) {
            let message = format!("`{value}` where a finite number is needed");
            return Err(Fault::new(&["parameters", key], Diagnostic::error(message)));
        }
        let values = self.stated_nonlinear(effect, site, given)?;
        let mut symbols: Vec<String> = values.iter().map(|(known, _)| known.name.to_string()).collect();
        let nonlinear = Nonlinear::new(values);
        if let Some((key, remedy)) = effect.misplaced(site, &nonlinear) {
            let stated = given.get(key).map(ToString::to_string).unwrap_or_default();
            return Err(fault(key, format!("`{key}: {stated}` of `{name}` at `{}`", site.name), remedy.into()));
        }
        let parameters = effect.parameters(self, site, &nonlinear);
        let mut amounts = IndexMap::new();
        for (key, value) in given {
            match (parameters.iter().find(|known| known.symbol == *key), value) {
                (Some(_), RawAmount::Number(value)) => {
                    amounts.insert(key.clone(), *value);
                }
                (Some(known), RawAmount::Name(_) | RawAmount::Numbers(_)) => {
                    let message = format!("`{key}: {value}` of `{name}`");
                    return Err(fault(key, message, format!("write a number ({})", known.unit)));
                }
                (None, _) if symbols.contains(key) || symbols.is_empty() && parameters.is_empty() => {}
                (None, _) => {
                    symbols.extend(parameters.into_iter().map(|known| known.symbol));
                    let remedy = format!("its parameters (SI): {}", symbols.join(", "));
                    return Err(fault(key, format!("`{name}` has no parameter `{key}`"), remedy));
                }
            }
        }
        Ok((nonlinear, amounts))
    }

    /// Switches an effect on: its amounts join the registry, or shift the constants of the model that it consists of.
    pub fn switch_on(&mut self, entry: EffectEntry) {
        let owner = entry.to_string();
        let alike = |known: &&SwitchedOn| {
            known.entry.effect.name() == entry.effect.name() && known.entry.site.name == entry.site.name
        };
        let owner = match self.effects.iter().filter(alike).count() {
            0 => owner,
            before => format!("{owner}#{}", before + 1),
        };
        let constants = entry.effect.constants(self, &entry.site, &entry.nonlinear);
        let mut slots: IndexMap<&str, Slot> = IndexMap::new();
        for (symbol, &nominal) in entry.amounts.iter().filter(|_| constants.is_empty()) {
            let parameter = Parameter {
                name: format!("{owner}.{symbol}"),
                kind: Kind::Other("SI"),
                group: Group::Effect,
                nominal,
                bounds: [f64::NEG_INFINITY, f64::INFINITY],
                tolerance: 1.0,
                free: false,
                closing: false,
                inverted: false,
            };
            slots.insert(symbol, self.registry.add(parameter));
        }
        let parameters = entry.effect.parameters(self, &entry.site, &entry.nonlinear);
        let own = |parameter: &EffectParameter| slots.get(parameter.symbol.as_str()).copied();
        let slots = if constants.is_empty() { parameters.iter().map(own).collect() } else { Vec::new() };
        let amount = |slot: Slot| entry.amounts.get(&self.registry[slot].name).copied().unwrap_or_default();
        let shifts = constants.into_iter().map(|slot| (slot, amount(slot))).collect();
        self.effects.push(SwitchedOn { entry, parameters, slots, shifts });
    }
}
