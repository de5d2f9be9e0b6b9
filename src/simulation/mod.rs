//! Campaigns made by the model itself: prediction plus noise, for planning and for checks whose truth is known.

mod arranging;
mod campaigns;

pub use arranging::{direction, lay_out, set_up};
pub use campaigns::{
    Loaded, Plan, all_points, carry_out, conditions, draw_configurations, draw_configurations_in, draw_errors,
    draw_in_box, generator, joint_box, measure, measure_with, simulate, unmeasured, usually_calibrated, within_limits,
};
