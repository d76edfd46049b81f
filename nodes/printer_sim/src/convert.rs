//! Between the simulator and the wire.

use crate::faults::{Component, Kind};
use crate::imu::Batch;
use crate::output::Truth;
use crate::scenario::{Course, Entry, FaultError};
use crate::wire::{HeightSample, WireTruth};
use fdm_loop_msgs::{
    BeadWidth, CompressedImage, FilamentReport, Header, ImuBatch, InjectFaultRequest, LayerHeight,
    PrintEvent, SimTruth, SimWire, TemperatureReport,
};
use models::units::{Celsius, Kelvin, Seconds};
use runtime::wire::{self, ImuReading, JpegFrame};

/// Frame of the inertial unit.
const IMU_FRAME: &str = "imu";
/// Optical frame of the camera.
const CAMERA_FRAME: &str = "camera_optical";
/// Source that a width measurement states until it is made from camera frames.
const STAND_IN: &str = "stand-in";

pub fn temperatures(
    stamp: Seconds,
    (hotend, bed, nozzle): (Celsius, Celsius, Option<Celsius>),
) -> TemperatureReport {
    TemperatureReport {
        header: Header::at(stamp.0),
        hotend_degc: hotend.0,
        bed_degc: bed.0,
        nozzle_degc: nozzle.map_or(f64::NAN, |temp| temp.0),
    }
}

pub fn filament(stamp: Seconds, counts: i64, quantum_m: f64) -> FilamentReport {
    FilamentReport { header: Header::at(stamp.0), counts, quantum_m }
}

pub fn width(exposed: Seconds, width_m: f64, sigma_m: f64) -> BeadWidth {
    BeadWidth { header: Header::at(exposed.0), width_m, sigma_m, source: STAND_IN.into() }
}

pub fn imu(batch: Batch) -> ImuBatch {
    let Batch { first, first_sequence, period, range_m_s2, samples } = batch;
    wire::imu_to_wire(&ImuReading { first, first_sequence, period, range_m_s2, samples }, IMU_FRAME)
}

pub fn frame(exposed: Seconds, jpeg: Vec<u8>) -> CompressedImage {
    wire::frame_to_wire(JpegFrame { exposed, jpeg }, CAMERA_FRAME)
}

pub fn note(who: &str, stamp: Seconds, text: String) -> PrintEvent {
    PrintEvent {
        header: Header::at(stamp.0),
        severity: PrintEvent::SEVERITY_INFO,
        who: who.to_owned(),
        what: "printer".into(),
        why: text,
        before: String::new(),
        after: String::new(),
    }
}

pub fn truth(truth: &Truth, motor_position_m: f64, first_onset: Option<Seconds>) -> SimTruth {
    let degc = |kelvin: f64| Celsius::from(Kelvin(kelvin)).0;
    SimTruth {
        header: Header::at(truth.stamp_s),
        path_time_s: truth.path_time_s,
        block_degc: degc(truth.block_k),
        nozzle_degc: degc(truth.nozzle_k),
        reference_degc: degc(truth.reference_k),
        bed_degc: degc(truth.bed_k),
        heater_power_w: truth.heater_w,
        wanted_position_m: truth.wanted_m,
        motor_position_m,
        delivered_position_m: truth.delivered_m,
        outlet_position_m: truth.outlet_m,
        outlet_speed_m_s: truth.outlet_m_s,
        slip: truth.slip,
        gain: truth.gain,
        depositing: truth.depositing,
        width_m: truth.width_m,
        target_width_m: truth.target_width_m,
        melt_force_n: truth.force_n,
        adhesion: truth.adhesion,
        porosity: truth.porosity,
        layer_shift_m: truth.layer_shift_m,
        fault_set_in: first_onset.is_some(),
        first_onset_s: first_onset.map_or(0.0, |onset| onset.0),
        deposit_s: truth.integrals.deposit_s,
        deposit_wanted_m: truth.integrals.wanted_m,
        deposit_delivered_m: truth.integrals.delivered_m,
        width_error_sq_s: truth.integrals.width_error_sq_s,
        quality_s: truth.integrals.quality_s,
    }
}

/// A height as sent: layers count from 0 there.
pub fn layer_height(sample: &HeightSample, sigma_m: f64) -> LayerHeight {
    LayerHeight {
        header: Header::at(sample.stamp.0),
        layer: sample.layer.saturating_sub(1),
        along_m: sample.position_m,
        height_m: sample.height_m,
        sigma_m,
    }
}

pub fn wire_truth(truth: &WireTruth) -> SimWire {
    SimWire {
        header: Header::at(truth.stamp.0),
        layer: truth.layer,
        depositing: truth.depositing,
        along_m: truth.along_m,
        wire_m_s: truth.speeds.wire_m_s,
        head_m_s: truth.speeds.head_m_s,
        height_m: truth.height_m,
        layers_complete: truth.figures.layers(),
        layer_rms_m: truth.figures.last_rms_m(),
        rms_m: truth.figures.rms_m(),
    }
}

/// A fault that was injected, with all that it is.
pub fn injected(who: &str, stamp: Seconds, what: &Entry) -> PrintEvent {
    PrintEvent { what: "fault_injected".to_owned(), ..note(who, stamp, what.to_string()) }
}

/// A fault as the service asks for it, from `now` on.
pub fn fault(now: Seconds, asked: &InjectFaultRequest) -> Result<Entry, FaultError> {
    let component = Component::from_name(&asked.component)
        .ok_or_else(|| FaultError::UnknownComponent { component: asked.component.clone() })?;
    let kind = Kind::from_name(&asked.kind).ok_or_else(|| FaultError::Unknown {
        component: asked.component.clone(),
        kind: asked.kind.clone(),
        allowed: crate::scenario::allowed_kinds(component),
    })?;
    // A stop time of zero means for good; NaN is no time and is refused by the range check.
    let duration_s = (asked.duration_s != 0.0).then_some(asked.duration_s);
    let course = Course { size: Some(asked.size), ramp_s: asked.ramp_s, duration_s };
    let entry = Entry::after(now, (component, kind), course, asked.start_s)?;
    // On the wire a seed of zero is none.
    if asked.seed == 0 { Ok(entry) } else { entry.seeded(asked.seed) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(component: &str, kind: &str, size: f64) -> InjectFaultRequest {
        InjectFaultRequest { component: component.into(), kind: kind.into(), size, ..Default::default() }
    }

    #[test]
    fn the_service_takes_what_a_scenario_file_may_ask_for() {
        for (component, kind, size) in [
            ("motion", "layer_shift_x", 8e-4),
            ("motion", "layer_shift_y", -8e-4),
            ("motion", "knock", 45.0),
            ("part", "detached", 0.0),
            ("extruder", "leak", 0.2),
            ("encoder", "off", 0.0),
            ("camera", "stuck", 0.0),
        ] {
            assert!(fault(Seconds(1.0), &asked(component, kind, size)).is_ok(), "{component} {kind}");
        }
    }

    #[test]
    fn the_service_says_what_there_is() {
        let refusal = |component, kind, size| {
            fault(Seconds(1.0), &asked(component, kind, size)).unwrap_err().to_string()
        };
        assert_eq!(
            refusal("bed", "knock", 1.0),
            "component = bed: there is none of this name; it can be extruder, filament, hotend_heater, \
             hotend_thermistor, bed_heater, bed_thermistor, encoder, imu, camera, fan, stop_input, ambient, motion, part"
        );
        assert!(refusal("motion", "slip", 1.0).contains("layer_shift_x, layer_shift_y, knock"));
        assert_eq!(refusal("motion", "layer_shift_x", 0.8), "size = 0.8 m: must be in [-0.05, 0.05]");
    }

    /// A fault of the past would begin at once, and a negative time is nobody's wish.
    #[test]
    fn times_out_of_range_are_refused_under_their_own_names() {
        let slip = asked("extruder", "slip", 0.1);
        let refusal = |asked: InjectFaultRequest| fault(Seconds(100.0), &asked).unwrap_err().to_string();
        let range = "must be in [0, 604800]";
        assert_eq!(
            refusal(InjectFaultRequest { start_s: -5.0, ..slip.clone() }),
            format!("start_s = -5 s: {range}")
        );
        assert_eq!(
            refusal(InjectFaultRequest { start_s: 1e9, ..slip.clone() }),
            format!("start_s = 1000000000 s: {range}")
        );
        assert_eq!(
            refusal(InjectFaultRequest { duration_s: -1.0, ..slip.clone() }),
            "duration_s = -1 s: must be in [0.001, 604800]"
        );
        assert_eq!(
            refusal(InjectFaultRequest { ramp_s: f64::NAN, ..slip.clone() }),
            format!("ramp_s = NaN s: {range}")
        );
        let later = InjectFaultRequest { start_s: 5.0, ramp_s: 2.0, duration_s: 9.0, ..slip };
        assert_eq!(
            fault(Seconds(100.0), &later).unwrap().to_string(),
            "extruder slip, size 0.1 (no unit), from 105.00 s of the simulation on, grows for 2 s, lasts 9 s"
        );
    }

    /// It went by unseen: a seed that changed nothing was accepted.
    #[test]
    fn a_seed_counts_where_something_is_random_and_is_refused_elsewhere() {
        let seeded = |component, kind, size, seed| {
            let asked = InjectFaultRequest { seed, ..asked(component, kind, size) };
            fault(Seconds(1.0), &asked).map(|entry| entry.to_string()).map_err(|error| error.to_string())
        };
        let spikes = |seed| seeded("hotend_thermistor", "spikes", 0.3, seed).unwrap();
        assert!(spikes(7).ends_with(", seed 7") && !spikes(0).contains("seed"));
        assert_eq!(
            seeded("extruder", "slip", 0.1, 7).unwrap_err(),
            "seed = 7: nothing of slip is random, leave it out (0); noise, spikes and loose take one"
        );
        assert!(seeded("extruder", "slip", 0.1, 0).is_ok());
    }

    #[test]
    fn a_batch_goes_out_whole_and_says_how_much_was_saturated() {
        let samples = vec![[156.9, 0.0, 9.81], [0.1, 0.2, 9.7]];
        let batch = Batch {
            first: Seconds(0.051),
            first_sequence: 50,
            period: Seconds(1e-3),
            range_m_s2: 156.9,
            samples,
        };
        let wire = imu(batch);
        assert_eq!((wire.first_sequence, wire.saturated, wire.x_m_s2.len()), (50, 1, 2));
        assert!((wire.z_m_s2[1] - 9.7).abs() < 1e-12);
    }
}
