//! What is chosen by name: control levels, sources of the pressure advance, forms of the filter.

use super::ADVANCES;
use anyhow::bail;
use mpc_controller::params::{AdvanceSource, Level};
use state_estimator::engine::Form;

/// A control level by name.
///
/// # Errors
/// Names the levels that there are.
pub fn level(name: &str) -> anyhow::Result<Level> {
    Ok(match name {
        "off" => Level::Off,
        "encoder" => Level::Encoder,
        "mpc" => Level::Mpc,
        _ => bail!("--control {name}: must be off, encoder or mpc"),
    })
}

/// A source of the pressure advance by name.
///
/// # Errors
/// Names the sources that there are.
pub fn advance(name: &str) -> anyhow::Result<AdvanceSource> {
    Ok(match name {
        "none" => AdvanceSource::None,
        "file" => AdvanceSource::File,
        "material" => AdvanceSource::Material,
        "planned" => AdvanceSource::Planned,
        "predicted" => AdvanceSource::Predicted,
        _ => bail!("--advance {name}: must be {}", ADVANCES.join(", ")),
    })
}

/// The name of a source.
pub(super) fn advance_name(source: AdvanceSource) -> &'static str {
    match source {
        AdvanceSource::None => "none",
        AdvanceSource::File => "file",
        AdvanceSource::Material => "material",
        AdvanceSource::Planned => "planned",
        AdvanceSource::Predicted => "predicted",
    }
}

/// The name of a control level.
pub(super) fn name_of(level: Level) -> &'static str {
    match level {
        Level::Off => "off",
        Level::Encoder => "encoder",
        Level::Mpc => "mpc",
    }
}

/// The name of a form of the filter, as the configuration has it.
pub(super) fn filter_name(form: Form) -> &'static str {
    match form {
        Form::SquareRoot => "square_root",
        Form::Unscented => "unscented",
        Form::Extended => "extended",
    }
}
