//! The standard catalogue of effects that a description leaves out, one file each.
//!
//! An effect ([`Effect`]) says where it can sit, which parameters it has, and what one unit of each changes in a reading.
//! To add one: its file, its line in [`Catalogue::standard`], its section in `docs/effects.md`. A program that has an effect
//! of its own adds it with [`Catalogue::with`]; see `examples/own_effect.rs`.

mod actuator_compliance;
mod backlash;
mod base_compliance;
mod bearing_compliance;
mod cable_torque;
mod encoder_quantisation;
mod frame_drift;
mod free_form;
mod gear_ratio;
mod geometry;
mod gravity_compensator;
mod hysteresis;
mod incidence;
mod instrument_scale;
mod joint_compliance;
mod joint_coupling;
mod joint_offset;
mod joint_stiffening;
mod link_compliance;
mod link_weight;
mod motor_eccentricity;
mod outliers;
mod payload;
mod refraction;
mod settling;
mod slip;
mod thermal_expansion;
mod transmission_error;
mod warm_up;

use std::sync::Arc;

pub use crate::model::{
    Catalogue, Change, Changes, Condition, Driver, Effect, EffectEntry, EffectParameter, Family, Nonlinear,
    NonlinearKind, NonlinearParameter, NonlinearValue, ReadingContext, Site, SiteKind, Survey,
};

impl Catalogue {
    /// The effects of `docs/effects.md`, in its order.
    pub fn standard() -> Self {
        Self::new(vec![
            Arc::new(geometry::Geometry),
            Arc::new(joint_offset::JointOffset),
            Arc::new(gear_ratio::GearRatio),
            Arc::new(transmission_error::TransmissionError),
            Arc::new(motor_eccentricity::MotorEccentricity),
            Arc::new(encoder_quantisation::EncoderQuantisation),
            Arc::new(cable_torque::CableTorque),
            Arc::new(joint_coupling::JointCoupling),
            Arc::new(backlash::Backlash),
            Arc::new(settling::Settling),
            Arc::new(hysteresis::Hysteresis),
            Arc::new(slip::Slip::Joint),
            Arc::new(slip::Slip::Tool),
            Arc::new(joint_compliance::JointCompliance),
            Arc::new(joint_stiffening::JointStiffening),
            Arc::new(bearing_compliance::BearingCompliance),
            Arc::new(link_compliance::LinkCompliance),
            Arc::new(actuator_compliance::ActuatorCompliance),
            Arc::new(gravity_compensator::GravityCompensator),
            Arc::new(link_weight::LinkWeight),
            Arc::new(payload::Payload),
            Arc::new(base_compliance::BaseCompliance),
            Arc::new(thermal_expansion::ThermalExpansion),
            Arc::new(warm_up::WarmUp::Link),
            Arc::new(warm_up::WarmUp::Base),
            Arc::new(warm_up::WarmUp::Tool),
            Arc::new(frame_drift::FrameDrift),
            Arc::new(instrument_scale::InstrumentScale),
            Arc::new(refraction::Refraction),
            Arc::new(incidence::Incidence),
            Arc::new(free_form::FreeForm),
            Arc::new(outliers::Outliers),
        ])
    }
}
