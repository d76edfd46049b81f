//! Laws of the network and its fit.

use super::chance::Stream;
use super::training::{Example, FitParams, RawFit};
use super::{Network, RawLayer};
use nalgebra::DVector;

fn fit(hidden: Vec<u32>, epochs: u32) -> FitParams {
    let raw = RawFit { hidden, members: 1, epochs, batch: 16, rate: 0.02, decay: 0.0, clip: 4.0 };
    FitParams::try_from(raw).unwrap()
}

/// A step function of the sum of two inputs: a line in the plane, which one layer of ReLU finds.
#[test]
fn a_fit_learns_what_it_is_shown_and_is_the_same_again() {
    let mut chance = Stream::new(1);
    let examples: Vec<Example> = (0..400)
        .map(|_| {
            let values = vec![chance.between((-1.0, 1.0)), chance.between((-1.0, 1.0))];
            let target = f64::from(u8::from(values[0] + values[1] > 0.3));
            Example { values, target, weight: 1.0 }
        })
        .collect();
    let params = fit(vec![8], 60);
    let scaling = params.scaling(&examples);
    let layers = params.fit(&scaling, &examples, &mut Stream::new(2));
    assert_eq!(layers, params.fit(&scaling, &examples, &mut Stream::new(2)));
    let network = Network::read("layers", 2, &layers).unwrap();
    let right = examples
        .iter()
        .filter(|example| (network.output(&scaling.of(&example.values)) > 0.5) == (example.target > 0.5))
        .count();
    assert!(right >= 390, "{right} of 400");
}

/// By hand: hidden max(0, 2*1 - 1) = 1 and max(0, -1) = 0; logit 3*1 + 5*0 - 1 = 2.
#[test]
fn the_forward_pass_is_the_written_one() {
    let layers = [
        RawLayer { weights: vec![vec![2.0], vec![-1.0]], bias: vec![-1.0, 0.0] },
        RawLayer { weights: vec![vec![3.0, 5.0]], bias: vec![-1.0] },
    ];
    let network = Network::read("layers", 1, &layers).unwrap();
    assert!((network.logit(&DVector::from_element(1, 1.0)) - 2.0).abs() < 1e-15);
}

#[test]
fn layers_that_do_not_fit_are_refused_by_name() {
    let wide = RawLayer { weights: vec![vec![1.0, 2.0]], bias: vec![0.0] };
    let error = Network::read("layers", 3, std::slice::from_ref(&wide)).unwrap_err();
    assert_eq!(error.to_string(), "network file: layers[0].weights[0] is 2 long, must be 3 long");
    let odd = RawLayer { weights: vec![vec![1.0, f64::NAN]], bias: vec![0.0] };
    let error = Network::read("layers", 2, &[odd]).unwrap_err();
    assert_eq!(error.to_string(), "network file: layers[0].weights[0][1] is NaN, must be finite");
}

/// 10 000 numbers: mean within 5/sqrt(N) of 0, mean square within 5 sqrt(2/N) of 1.
#[test]
fn normal_numbers_are_normal() {
    let mut chance = Stream::new(3);
    let numbers: Vec<f64> = (0..10_000).map(|_| chance.normal()).collect();
    let mean = numbers.iter().sum::<f64>() / 1e4;
    let square = numbers.iter().map(|number| number * number).sum::<f64>() / 1e4;
    assert!(mean.abs() < 0.05 && (square - 1.0).abs() < 0.071, "{mean} {square}");
}
