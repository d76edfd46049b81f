//! What start code and tables say.

use super::super::tests::setup;
use super::*;

fn row(temperature_c: f64, height_mm: f64, advance_s: f64) -> Row {
    let interval_of = IntervalOf::VirtualTestLine;
    let (half_width_s, in_hull, outside) = (0.01, true, vec![]);
    Row { temperature_c, height_mm, advance_s, half_width_s, interval_of, in_hull, outside }
}

#[test]
fn a_conditional_names_the_nearest_height() {
    let rows = [row(215.0, 0.1, 0.9), row(215.0, 0.2, 0.63), row(215.0, 0.3, 0.59)];
    assert_eq!(
        macro_text(PRUSASLICER, MARLIN, &rows),
        "M900 K{if layer_height<0.150}0.9000{elsif layer_height<0.250}0.6300{else}0.5900{endif}"
    );
    assert_eq!(macro_text(PRUSASLICER, MARLIN, &rows[..1]), "M900 K0.9000");
}

/// Every temperature that was asked for is in the start code, in the order in which a slicer meets the conditions.
#[test]
fn a_conditional_names_the_nearest_temperature_first() {
    let rows = [row(200.0, 0.1, 1.0), row(200.0, 0.2, 0.7), row(220.0, 0.1, 0.8), row(220.0, 0.2, 0.6)];
    assert_eq!(
        macro_text(PRUSASLICER, KLIPPER, &rows),
        "SET_PRESSURE_ADVANCE ADVANCE={if temperature[0]<210.000 and layer_height<0.150}1.0000\
         {elsif temperature[0]<210.000}0.7000{elsif layer_height<0.150}0.8000{else}0.6000{endif}"
    );
    let one_height = [rows[0].clone(), rows[2].clone()];
    assert_eq!(
        macro_text(ORCASLICER, MARLIN, &one_height),
        "M900 K{if nozzle_temperature[0]<210.000}1.0000{else}0.8000{endif}"
    );
}

/// As people write lists.
#[test]
fn values_are_separated_by_commas_or_blanks() {
    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        export: ExportArgs,
    }
    for line in ["export --temperature 230 240", "export --temperature 230,240 --width 0.4"] {
        let line: Line = clap::Parser::try_parse_from(line.split(' ')).ok().unwrap();
        assert_eq!(line.export.temperature, [230.0, 240.0]);
    }
}

#[test]
fn all_temperatures_are_exported_and_odd_ones_refused() {
    let (config, setup) = setup();
    let printed = Printed {
        drive: super::super::DriveName::Bowden,
        polymer: "PLA".to_owned(),
        config: None,
        models: None,
        json: None,
    };
    let of = |temperature: &[f64], height: &[f64]| {
        let (temperature, height) = (temperature.to_vec(), height.to_vec());
        let args = ExportArgs { printed: printed.clone(), temperature, height, width: 0.45 };
        let (predictor, networks) = args.printed.predictor(&setup, &config)?;
        export(&args, &setup, (&predictor, networks))
    };
    let whole = of(&[220.0, 200.0], &[0.2, 0.1]).unwrap();
    assert_eq!(whole.rows.len(), 4);
    for row in &whole.rows {
        assert!(whole.prusaslicer_marlin.contains(&format!("{:.4}", row.advance_s)), "{whole:?}");
    }
    // PLA's data end at 230 degC.
    let partly = of(&[220.0, 240.0], &[0.2]).unwrap();
    assert!(partly.orcaslicer_klipper.ends_with("{endif} ; by the physical model at 240 degC 0.2 mm"));
    assert!(text(&partly).contains("physical model: temperature 240 degC is outside of 200 to 230 degC\n"));
    assert!(!text(&whole).contains("by the physical model"), "{}", text(&whole));
    let refused = |temperature: &[f64], height: &[f64]| of(temperature, height).unwrap_err().to_string();
    assert_eq!(refused(&[215.0, 20.0], &[0.2]), "--temperature 20 degC: must be in [160, 320] degC");
    assert_eq!(refused(&[215.0], &[0.2, 0.2]), "--height 0.2: is there twice");
    assert_eq!(refused(&[215.0], &[]), "--height: no value");
    // No drive needs what the physical model says there: no start code for the other conditions either.
    assert_eq!(refused(&[215.0, 160.0], &[0.05]), "--temperature 160 --height 0.05");
}
