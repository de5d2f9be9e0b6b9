//! What a certificate says in addition to figures: who measured what with which instrument.

#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `report --certificate` prints as it stands here; nothing is computed from it but the verdict on the tolerance.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RawCertificate {
    /// Number of the certificate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub number: Option<String>,
    /// For whom.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub customer: Option<String>,
    /// Where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// When.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Who measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
    /// Maker and type of the robot, where the description's name is not enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// Its serial number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot_serial: Option<String>,
    /// Controller, with version and serial number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controller: Option<String>,
    /// Tool and load of the test.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tool: Option<String>,
    /// The instrument.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instrument: Option<String>,
    /// Its serial number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instrument_serial: Option<String>,
    /// To which standard it is traceable: certificate of its calibration, and until when that is valid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub traceability: Option<String>,
    /// Ambient temperature, with its unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature: Option<String>,
    /// Anything else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remarks: Option<String>,
    /// Greatest position error that is allowed, in the unit of lengths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
}

impl RawCertificate {
    /// What is stated, with its label, in the order in which it is printed.
    pub fn rows(&self) -> Vec<(&'static str, &str)> {
        let rows = [
            ("certificate", &self.number),
            ("customer", &self.customer),
            ("place", &self.place),
            ("date", &self.date),
            ("operator", &self.operator),
            ("robot", &self.robot),
            ("serial number", &self.robot_serial),
            ("controller", &self.controller),
            ("tool and load", &self.tool),
            ("instrument", &self.instrument),
            ("instrument's serial number", &self.instrument_serial),
            ("traceable to", &self.traceability),
            ("temperature", &self.temperature),
            ("remarks", &self.remarks),
        ];
        rows.into_iter().filter_map(|(label, text)| Some((label, text.as_deref()?))).collect()
    }

    /// What a reader of a certificate looks for, and it does not say.
    pub fn missing(&self) -> Vec<&'static str> {
        let needed = [
            ("date", self.date.is_none()),
            ("operator", self.operator.is_none()),
            ("robot_serial", self.robot_serial.is_none()),
            ("instrument", self.instrument.is_none()),
            ("instrument_serial", self.instrument_serial.is_none()),
            ("traceability", self.traceability.is_none()),
            ("temperature", self.temperature.is_none()),
        ];
        needed.into_iter().filter(|(_, lacks)| *lacks).map(|(name, _)| name).collect()
    }
}
