//! What may change while the node is active.

/// Noise of the model and of the sensors. Gates, windows, ages and bounds belong together, prior and form of the filter
/// count at its start alone: these may change while the node is inactive.
pub const LIVE: [&str; 10] = [
    "process.block_k",
    "process.nozzle_k",
    "process.sensor_k",
    "process.flow_rel",
    "process.slip",
    "process.gain",
    "thermistor.sigma_k",
    "nozzle_sensor.sigma_k",
    "encoder.relative",
    "width.sigma_min_m",
];
