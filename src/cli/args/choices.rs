//! Enums of the library that are choices on the command line: what each is called there, and a line of help.

use clap::builder::PossibleValue;

use crate::blind::Kind;
use crate::estimation::fuzzy::Structure;
use crate::estimation::{Scheme, Split, Weights};
use crate::identifiability::Scaling;
use crate::planning::stiffest::Least;
use crate::render::program::Moves;

macro_rules! choices {
    ($($of:ty { $($variant:ident = $name:literal: $help:literal,)* })*) => {$(
        impl clap::ValueEnum for $of {
            fn value_variants<'a>() -> &'a [Self] {
                &[$(Self::$variant),*]
            }

            fn to_possible_value(&self) -> Option<PossibleValue> {
                Some(match self {
                    $(Self::$variant => PossibleValue::new($name).help($help),)*
                    // What is no choice.
                    #[allow(unreachable_patterns)]
                    _ => return None,
                })
            }
        }
    )*};
}

choices! {
    Scaling {
        Norm = "norm": "To length one",
        Tolerance = "tolerance": "By the parameters' stated tolerances",
    }
    Structure {
        Grid = "grid": "All combinations of the sets of each input",
        Tree = "tree": "Splits along one input each",
    }
    Split {
        Prior = "prior": "In proportion to what the description says",
        MinimumNorm = "minimum-norm": "The smallest sum of squared compliances",
    }
    Scheme {
        Batch = "batch": "All at once",
        PoseByPose = "pose-by-pose": "Configuration by configuration",
        Alternating = "alternating": "Base and tool, then geometry, in turns",
    }
    Weights {
        Stated = "stated": "The campaign's stated noise",
        Equal = "equal": "All alike (OLS)",
        Direction = "direction": "Noise of each direction, from a first fit (WLS)",
    }
    Least {
        Rms = "rms": "Its root mean square",
        Max = "max": "The greatest",
    }
    Moves {
        Joints = "joints": "Joints, which leave nothing to the controller's own geometry",
        Poses = "poses": "Poses of the tool in the controller's own geometry",
    }
    Kind {
        Single = "single": "One effect",
        Pair = "pair": "Two",
        Triple = "triple": "Three",
        Null = "null": "None",
        Unknown = "unknown": "One that is in no catalogue",
        Mixture = "mixture": "One effect, and one that is in no catalogue",
        Trap = "trap": "Readings with a mistake, such as a wrong unit; in a workshop only",
    }
}
