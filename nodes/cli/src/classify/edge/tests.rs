use super::*;
use std::path::PathBuf;

fn config() -> ConfigDir {
    ConfigDir::find(Some(&PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../config"))).unwrap()
}

/// The committed settings, but so small that a test can run them.
fn tiny(epochs: u32, threads: u32) -> Settings {
    let text = std::fs::read_to_string(config().file("models/edge_training.yaml")).unwrap();
    let text: String = text
        .lines()
        .map(|line| match line.trim_start().split(':').next() {
            Some("epochs") => format!("  epochs: {epochs}\n"),
            Some("threads") => format!("threads: {threads}\n"),
            Some("judged") => "  judged: 2\n".to_owned(),
            Some("hidden") => "  hidden: 8\n".to_owned(),
            _ => format!("{line}\n"),
        })
        .collect();
    let path = std::env::temp_dir().join(format!("fdm_edge_{}_{epochs}_{threads}.yaml", std::process::id()));
    std::fs::write(&path, text).unwrap();
    let settings = runtime::params::from_yaml(&path).unwrap();
    std::fs::remove_file(path).unwrap();
    settings
}

/// After one pass over the profiles of twelve cameras the network is hardly more than chance; six hundred must halve what
/// its answers are wrong by on cameras that it never saw.
#[test]
fn a_tiny_training_improves_on_next_to_none_and_does_not_depend_on_the_threads() {
    let (optics, settings, looks) = (Optics::load(&config()).unwrap(), tiny(600, 2), 7_100_000..7_100_012);
    let (done, late) = train(&optics, &settings, looks.clone()).unwrap();
    assert!(done.text().contains("looks 7100000 to 7100011 of the simulated printer's style 'test'"));

    let profiles = gather(&optics, &tiny(600, 1), (Style::Test, looks)).unwrap();
    assert!(profiles.len() == done.profiles && done.profiles > 12, "{done:?}");
    let ruler = optics.ruler(&settings.scene);
    let fitted = |settings: &Settings| {
        let mut stream = Stream::new(settings.seed);
        fit(&profiles, &ruler, &settings.fit, &mut || stream.uniform(), &mut |_, _| {}).unwrap()
    };
    assert_eq!(fitted(&settings), late);

    let unseen = gather(&optics, &settings, (Style::Test, 7_100_012..7_100_018)).unwrap();
    let wrong_m = |model: &EdgeModel| {
        let found = judge(model, &unseen, &ruler, optics.width.range_rel);
        let [found_count, count] =
            [found.located, found.profiles].map(|n| f64::from(u32::try_from(n).unwrap()));
        // An edge that was not found counts as wrong as the search is wide: 0.45 of half of 0.44 mm.
        let squares = if found.located == 0 { 0.0 } else { found.bias_m.powi(2) + found.sd_m.powi(2) };
        ((found_count * squares + (count - found_count) * 1e-8) / count).sqrt()
    };
    let [early_m, late_m] = [&fitted(&tiny(1, 1)), &late].map(wrong_m);
    assert!(late_m < 0.5 * early_m, "{early_m:e} {late_m:e}");
}

/// A requirement that another argument rules out is dropped by the parser, so each wrong pair must be ruled out itself.
#[test]
fn what_belongs_to_the_edge_alone_is_refused_elsewhere() {
    #[derive(Debug, clap::Parser)]
    struct Command {
        #[command(flatten)]
        classify: crate::classify::ClassifyArgs,
    }
    let refused = |words: &[&str]| {
        let words = ["classify"].iter().chain(words);
        <Command as clap::Parser>::try_parse_from(words).map(|command| command.classify.edge.seeds).is_err()
    };
    assert!(!refused(&["--train-edge"]) && !refused(&["--train", "--out", "x"]));
    assert!(!refused(&["--train-edge", "--seeds", "1..3", "--out", "x"]));
    let wrong: [&[&str]; 7] = [
        &["--train-edge", "--train"],
        &["--train-edge", "a.png"],
        &["--train", "--seeds", "1..3"],
        &["--seeds", "1..3", "a.png"],
        &["--train-edge", "--seeds", "3..1"],
        &["--out", "x", "a.png"],
        &["--out", "x", "--manifest", "m.csv"],
    ];
    for words in wrong {
        assert!(refused(words), "{words:?}");
    }
}

#[test]
fn seeds_are_two_numbers_in_order() {
    assert_eq!(seeds("3..9"), Ok(3..9));
    for text in ["", "3", "9..3", "3..3", "a..b", "-1..3", "0..1000000000000001"] {
        assert!(seeds(text).is_err(), "{text}");
    }
}
