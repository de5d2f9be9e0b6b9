//! How grave a diagnostic is, and what kind of fault it reports.

use serde::{Serialize, Serializer};

/// How grave a [`super::Diagnostic`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Worth knowing; the file is still usable.
    Warning,
    /// The file, or the result, cannot be used.
    Error,
}

/// Makes the codes, their list and their names from one table.
macro_rules! codes {
    ($($(#[$about:meta])* $variant:ident $name:literal,)*) => {
        /// What kind of fault a [`super::Diagnostic`] reports; programs branch on this, never on the message. What each
        /// means and what to do stands in `docs/diagnostics.md`, a section each; `elastogeo explain CODE` prints it.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Code {
            $($(#[$about])* $variant,)*
        }

        impl Code {
            /// All codes.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// Its name in JSON and in the docs.
            ///
            /// ```
            /// use elastogeo::diagnostic::Code;
            ///
            /// assert_eq!(Code::NotConverged.name(), "not-converged");
            /// ```
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

codes! {
    /// A file that cannot be opened, or is no text.
    Unreadable "unreadable",
    /// A file that holds nothing.
    Empty "empty",
    /// The text does not follow its format: YAML, XML, CSV, a coupling.
    Syntax "syntax",
    /// A key, column or name that nothing declares.
    Unknown "unknown",
    /// Something that is required is absent.
    Missing "missing",
    /// Given twice.
    Duplicate "duplicate",
    /// A value of the wrong type, out of its range, or in contradiction to another.
    Invalid "invalid",
    /// Elements that do not fit together: frames, loops, drivers of joints.
    Structure "structure",
    /// A usable value that is probably not meant: mostly a matter of units.
    Doubtful "doubtful",
    /// Content that cannot be of the robot that is described; `--force` goes on.
    Implausible "implausible",
    /// Readings, joint columns or constants of the description are in another unit than declared; `--force` goes on.
    WrongUnits "wrong-units",
    /// The files fit the description when they are read otherwise: a sign, the order of columns or rows, a left-handed frame,
    /// a zero; `--force` goes on.
    Misread "misread",
    /// Readings and description differ by far more than tolerances and noise allow, and nothing explains it.
    UnlikeDescription "unlike-description",
    /// Calibrated constants are far from the description; beyond reason an error, and `--force` goes on.
    MovedFar "moved-far",
    /// Calibration makes readings worse that it did not see; far worse an error, and `--force` goes on.
    WorseThanRegistered "worse-than-registered",
    /// Residuals are far below or above the noise that is stated.
    NoiseUnlikeStated "noise-unlike-stated",
    /// Too few configurations, or too few readings for what is fitted, to conclude anything.
    TooLittleData "too-little-data",
    /// Sessions, or files, do not share the base or the tool that the campaign says they share.
    SessionsDiffer "sessions-differ",
    /// The other columns of the joints (commanded for recorded ones, or the reverse) fit the readings much better.
    OtherJoints "other-joints",
    /// Readings are copies of others, come back in time, or have the name of another configuration.
    SuspectReadings "suspect-readings",
    /// A few readings are far from the fit to the others.
    OutlyingReadings "outlying-readings",
    /// What is left steps at one row: instrument, base or marker was moved.
    MovedMidway "moved-midway",
    /// The computation has no answer for this input.
    NotComputed "not-computed",
    /// A fit stopped before it reached a minimum.
    NotConverged "not-converged",
    /// A description that was to be written cannot be read back, or says something else.
    UnusableResult "unusable-result",
    /// Base or tool have directions that the readings hardly show, held as described.
    WeakDirection "weak-direction",
    /// Fixed reflectors moved against the instrument.
    ReferencesMoved "references-moved",
    /// The noise that is stated is not what readings without the robot show.
    NoiseDisagrees "noise-disagrees",
    /// Readings of one configuration share an error, and intervals count it.
    DependentReadings "dependent-readings",
    /// A spring, or its free length, is held where results depend on it: it may explain the gap, and intervals take it as exact.
    SpringsHeld "springs-held",
    /// Configurations or loads lie outside the range of the readings by which a description was fitted.
    OutsideValidity "outside-validity",
    /// Base and tool of a description are of another set-up than those of the readings.
    AnotherPlacement "another-placement",
    /// Terms that belong to a session are not written into the robot.
    OfTheSession "of-the-session",
}

impl Code {
    /// Whether it is about the plausibility of content: a refusal then has exit status 2, and `--force` makes it a warning.
    pub fn is_plausibility(self) -> bool {
        matches!(
            self,
            Self::Implausible
                | Self::WrongUnits
                | Self::Misread
                | Self::UnlikeDescription
                | Self::MovedFar
                | Self::WorseThanRegistered
        )
    }

    /// Whether values that were fitted to such readings are not written into a description, unless that is forced: all that is
    /// implausible, and readings that do not belong together. Too great a residual is no reason: it is the gap. Nor are constants
    /// that moved: that is what a calibration is for.
    pub fn forbids_saving(self) -> bool {
        self.is_plausibility() && self != Self::MovedFar
            || matches!(
                self,
                Self::TooLittleData
                    | Self::SessionsDiffer
                    | Self::SuspectReadings
                    | Self::OutlyingReadings
                    | Self::MovedMidway
                    | Self::UnusableResult
            )
    }

    /// Whether it casts doubt on the figures of a result, and stands before them.
    pub fn is_about_figures(self) -> bool {
        self.is_plausibility()
            || matches!(
                self,
                Self::NoiseUnlikeStated
                    | Self::TooLittleData
                    | Self::SessionsDiffer
                    | Self::SuspectReadings
                    | Self::OutlyingReadings
                    | Self::MovedMidway
                    | Self::SpringsHeld
                    | Self::UnusableResult
            )
    }
}

impl Serialize for Code {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
