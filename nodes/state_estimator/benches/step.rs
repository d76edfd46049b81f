//! A step of each form of the filter: ten states, six measurements. `fdm bench estimator` sets it beside FilterPy.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{SMatrix, SVector};
use state_estimator::engine::{Engine, Form};
use state_estimator::ukf::{Gaussian, Measurement, Spread};
use std::hint::black_box;

const N: usize = 10;
const M: usize = 6;

fn step(engine: &mut Engine<N>, noise: &SMatrix<f64, N, N>, measurement: &Measurement<M>) {
    engine.predict(noise, |x| {
        SVector::from_fn(|i, _| {
            let next = x[(i + 1) % N];
            x[i] + 0.05 * (0.3 * next - 0.05 * next.powi(3) - 0.5 * x[i])
        })
    });
    engine.update(measurement, |x| SVector::from_fn(|i, _| x[i] + 0.1 * x[i + N - M].powi(2)));
}

fn forms(criterion: &mut Criterion) {
    let prior = Gaussian { mean: SVector::zeros(), covariance: SMatrix::identity() * 0.04 };
    let noise = SMatrix::identity() * 1e-4;
    let measurement =
        Measurement { value: SVector::repeat(0.3), noise: SMatrix::identity() * 0.01, gate: f64::INFINITY };
    for (name, form) in [("root", Form::SquareRoot), ("plain", Form::Unscented), ("extended", Form::Extended)]
    {
        let mut engine = Engine::new(form, prior, Spread { alpha: 0.3, beta: 2.0, kappa: 0.0 });
        criterion.bench_function(&format!("step of 10 states, 6 measurements: {name}"), |bencher| {
            bencher.iter(|| step(black_box(&mut engine), black_box(&noise), black_box(&measurement)));
        });
    }
}

criterion_group!(steps, forms);
criterion_main!(steps);
