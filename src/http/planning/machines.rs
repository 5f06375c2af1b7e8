//! `GET /v1/machines`: the machines that a request can name in place of their limits.

use crate::http::problem::ProblemBody;
use crate::http::wire::answer;
use crate::motion::{PRESETS, Preset};
use axum::Json;

answer! {
    /// All presets.
    #[schema(as = Machines)]
    pub(crate) struct MachinesAnswer {
        /// The machines, from the slowest drives to the fastest.
        machines: Vec<MachineAnswer>,
    }

    /// A machine by its name.
    #[schema(as = MachinePreset)]
    struct MachineAnswer of (preset: &Preset) {
        /// The name for `machine.preset`; stable.
        name: &'static str [example = "five_axis_vmc"] = preset.name,
        /// The class of machines.
        description: &'static str = preset.description,
        /// V, the feed rate of finishing, in mm/min.
        feed_rate_mm_min: f64 [exclusive_minimum = 0, example = 5000.0] = preset.limits.feed_rate.mm_min(),
        /// A, the largest acceleration along the path, in m/s^2.
        acceleration_m_s2: f64 [exclusive_minimum = 0, example = 6.0] = preset.limits.acceleration.mm_s2() / 1e3,
        /// J, the largest jerk along the path, in m/s^3.
        jerk_m_s3: f64 [exclusive_minimum = 0, example = 40.0] = preset.limits.jerk.mm_s3() / 1e3,
        /// A path tolerance that is usual for finishing. Not applied unless `machine.path_tolerance_mm` states it.
        usual_path_tolerance_mm: f64 [exclusive_minimum = 0, example = 0.01] = preset.usual_path_tolerance.mm(),
        /// The publication of the values, or "typical" if they are the usual order of magnitude of the class.
        source: &'static str = preset.source,
    }
}

/// The machine presets
///
/// The machines that `machine.preset` can name if the limits of a machine are not known, each with its limits and their
/// source.
#[utoipa::path(
    get, path = "/v1/machines", tag = "planning", operation_id = "machines",
    responses(
        (status = 200, description = "The presets", body = MachinesAnswer),
        (status = 503, description = "The server is busy; try again after the time in Retry-After", body = ProblemBody, content_type = "application/problem+json"),
    ),
)]
pub(crate) async fn list() -> Json<MachinesAnswer> {
    Json(MachinesAnswer { machines: PRESETS.iter().map(MachineAnswer::of).collect() })
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // the conversion back to the stated unit is exact for these values
mod tests {
    use super::*;

    #[test]
    fn limits_are_shown_in_the_units_in_which_they_are_stated() {
        let shown: Vec<_> = PRESETS.iter().map(MachineAnswer::of).collect();
        let five_axis = shown.iter().find(|machine| machine.name == "five_axis_vmc").unwrap();
        assert_eq!((five_axis.feed_rate_mm_min, five_axis.acceleration_m_s2, five_axis.jerk_m_s3), (5000.0, 6.0, 40.0));
        let hobby = shown.iter().find(|machine| machine.name == "hobby_router").unwrap();
        assert_eq!((hobby.feed_rate_mm_min, hobby.acceleration_m_s2, hobby.jerk_m_s3), (2500.0, 0.4, 8.0));
    }
}
