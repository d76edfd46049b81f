//! `fdm advance predict`: K of one condition.

use super::networks::{IntervalOf, Networks, answered, outside};
use super::{Place, Printed, Setup};
use crate::config::ConfigDir;
use crate::output::{self, Json};
use advance_predictor::compensation::Source;
use clap::Args;
use models::advance::DriveKind;
use models::command::AdvanceLaw;
use serde::Serialize;

/// Foretells K.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct PredictArgs {
    #[command(flatten)]
    printed: Printed,
    #[command(flatten)]
    place: Place,
}

/// The figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Drive.
    pub drive: DriveKind,
    /// Polymer.
    pub polymer: String,
    /// Temperature.
    pub temperature_c: f64,
    /// Layer height.
    pub height_mm: f64,
    /// Line width.
    pub width_mm: f64,
    /// K, for Marlin and Klipper alike.
    pub advance_s: f64,
    /// Half width of its interval.
    pub half_width_s: f64,
    /// What the interval is of.
    pub interval_of: IntervalOf,
    /// What the graph attaches to moves: filament held over the feed u, `linear_s u + shear_m u^index`.
    pub law: Option<Law>,
    /// Whether the condition lies inside the hull of the networks' data.
    pub in_hull: bool,
    /// What of the condition lies outside of it.
    pub outside: Vec<String>,
    /// Who answered.
    pub source: Source,
    /// The networks that were asked.
    pub networks: Networks,
    /// What the physical model says, unscaled.
    pub physics_s: Option<f64>,
}

/// The lag over the feed, of which one K is the secant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Law {
    /// Linear part `[s]`.
    pub linear_s: f64,
    /// Scale of the melt's part `[m (s/m)^n]`.
    pub shear_m: f64,
    /// Flow index `[-]`.
    pub index: f64,
    /// Its slope at the speeds of the test line, slow and fast `[s]`; the one K lies between.
    pub test_line_s: [f64; 2],
}

/// Runs the command.
///
/// # Errors
/// One line with the reason.
pub fn run(args: &PredictArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.printed.config.as_deref())?;
    let json = Json::new(args.printed.json.as_deref());
    json.check()?;
    let printed = &args.printed;
    Setup::check_apart(printed.json.as_deref(), &config, printed.models.as_deref())?;
    let figures = figures(args, &config)?;
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

fn figures(args: &PredictArgs, config: &ConfigDir) -> anyhow::Result<Figures> {
    let setup = Setup::load(config)?;
    let drive = args.printed.drive.into();
    let (polymer, at) = (args.printed.polymer(), args.place.condition());
    setup.check(&polymer, &args.place)?;
    let (predictor, networks) = args.printed.predictor(&setup, config)?;
    let foretold = predictor.predict(&polymer, &at)?;
    let law = predictor.law(&polymer, &at, foretold.advance).map(|law| {
        let AdvanceLaw { linear_s, shear, index } = law;
        let line = &setup.physics.test_line;
        let outlet_m_s = |head_m_s| setup.physics.drive(drive).outlet_m_s(&at, head_m_s);
        let test_line_s = [line.low_m_s, line.high_m_s].map(|head_m_s| law.lag_s(outlet_m_s(head_m_s)));
        Law { linear_s, shear_m: shear, index, test_line_s }
    });
    Ok(Figures {
        drive,
        temperature_c: args.place.temperature,
        height_mm: args.place.height,
        width_mm: args.place.width,
        advance_s: foretold.advance.0,
        half_width_s: foretold.half_width.0,
        interval_of: IntervalOf::of(foretold.source, predictor.ensemble()),
        law,
        in_hull: foretold.source == Source::Network,
        outside: outside(predictor.ensemble(), &polymer, &at),
        source: foretold.source,
        networks,
        physics_s: setup.physics.secant_s(drive, &polymer, &at),
        polymer,
    })
}

/// What start code says of an answer that is not the networks'.
pub(super) const BY_PHYSICS: &str = " ; by the physical model";

/// The law first: where moves carry trims the graph executes it, and one K holds at one speed alone.
fn text(figures: &Figures) -> String {
    let physics = figures.physics_s.map_or_else(|| "-".to_owned(), |advance_s| format!("{advance_s:.4} s"));
    let factor = figures.physics_s.map_or(1.0, |physics_s| figures.advance_s / physics_s);
    // Outside it is 1, but for own lines.
    let scaled = if figures.in_hull || (factor - 1.0).abs() < 1e-9 {
        String::new()
    } else {
        format!("; scaled by {factor:.3}, as measured lines say at the edge")
    };
    let law = figures.law.map_or_else(
        || "-".to_owned(),
        |law| {
            let [slow_s, fast_s] = law.test_line_s;
            format!("{slow_s:.4} s at the test line's slow speed, {fast_s:.4} s at its fast one")
        },
    );
    format!(
        "lag by feed  {law}: the graph attaches it to moves\n\
         one K        {k:.4} s +- {:.4} s ({}), for firmware\n\
         from         {}{scaled}\n\
         networks     {}\n\
         physics      {physics}\n\
         Marlin       M900 K{k:.4}{by}\n\
         Klipper      SET_PRESSURE_ADVANCE ADVANCE={k:.4}{by}",
        figures.half_width_s,
        figures.interval_of.text(),
        answered(&figures.outside),
        figures.networks.text(),
        k = figures.advance_s,
        by = if figures.in_hull { "" } else { BY_PHYSICS },
    )
}

#[cfg(test)]
mod tests {
    use super::super::DriveName;
    use super::super::tests::setup;
    use super::*;

    fn of(polymer: &str, place: Place) -> anyhow::Result<Figures> {
        let (config, _) = setup();
        let (drive, polymer) = (DriveName::Bowden, polymer.to_owned());
        let printed = Printed { drive, polymer, config: None, models: None, json: None };
        figures(&PredictArgs { printed, place }, &config)
    }

    fn figures_of(temperature: f64) -> Figures {
        of("pla", Place { temperature, height: 0.2, width: 0.4 }).unwrap()
    }

    /// 160 degC is no temperature of ABS: the physical model comes to 97 s.
    #[test]
    fn a_k_that_no_drive_has_is_no_answer() {
        let error =
            of("abs", Place { temperature: 160.0, height: 0.05, width: 0.15 }).unwrap_err().to_string();
        assert!(error.starts_with("no answer: K 9"), "{error}");
        assert!(error.ends_with(" is outside of 0.3 to 1.5 s of a bowden drive"), "{error}");
    }

    /// Nobody is to read the interval of synthetic lines as one of printers.
    #[test]
    fn the_interval_says_what_it_is_of() {
        let inside = figures_of(215.0);
        let json = serde_json::to_value(&inside).unwrap();
        assert_eq!(json["interval_of"], "virtual_test_line");
        assert!(text(&inside).contains("95 % of virtual test lines; no printer was involved"));
        let outside = figures_of(240.0);
        assert_eq!(serde_json::to_value(&outside).unwrap()["interval_of"], "assumed_doubt");
        assert!(text(&outside).contains("(an assumption)"));
        let own = Figures { advance_s: 1.2 * outside.physics_s.unwrap(), ..outside.clone() };
        assert!(
            text(&own).contains("; scaled by 1.200, as measured lines say")
                && !text(&outside).contains("scaled")
        );
        let told = "OUTSIDE of the networks' data: temperature 240 degC is outside of 200 to 230 degC\n";
        assert!(text(&outside).contains(told), "{}", text(&outside));
        assert_eq!(text(&outside).matches(BY_PHYSICS).count(), 2, "{}", text(&outside));
        assert!(!text(&inside).contains("physical model") && inside.outside.is_empty());
        assert!(text(&outside).contains(&outside.networks.file), "{}", text(&outside));
    }

    /// The one K is the law's secant between the speeds of the test line: the slopes at its ends lie about it.
    #[test]
    fn the_law_belongs_to_the_k() {
        let figures = figures_of(215.0);
        let [slow_s, fast_s] = figures.law.unwrap().test_line_s;
        assert!(slow_s > figures.advance_s && figures.advance_s > fast_s, "{figures:?}");
        assert!(text(&figures).starts_with(&format!("lag by feed  {slow_s:.4} s")), "{}", text(&figures));
    }
}
