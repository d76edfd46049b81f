//! Why the supervisor acts, with the ID of the fault catalogue and what a person should do.

use serde::{Deserialize, Serialize};

use crate::event::Defect;

/// How strongly a cause is answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Reaction {
    /// Corrections ramp back to the slicer's values; the print goes on.
    Degrade,
    /// The job is paused.
    Pause,
    /// Heaters off, latched.
    SafeOff,
    /// Emergency stop and mains relay, latched.
    Estop,
}

macro_rules! causes {
    ($($name:ident, $id:literal, $text:literal, $todo:literal;)*) => {
        /// Why the supervisor acts.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Cause {
            $(#[doc = concat!($id, ": ", $text, ".")] $name,)*
        }

        impl Cause {
            /// Every cause.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];
            /// How many there are.
            pub const COUNT: usize = Self::ALL.len();

            /// ID in the fault catalogue.
            #[must_use]
            pub fn id(self) -> &'static str {
                match self { $(Self::$name => $id,)* }
            }

            /// What was seen.
            #[must_use]
            pub fn text(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }

            /// What a person should do.
            #[must_use]
            pub fn what_to_do(self) -> &'static str {
                match self { $(Self::$name => $todo,)* }
            }
        }
    };
}

causes! {
    HotendRange, "S1", "hot end temperature outside of the possible range",
        "check thermistor and its plug, then `fdm acknowledge`";
    BedRange, "S1", "bed temperature outside of the possible range",
        "check the bed's thermistor and its plug, then `fdm acknowledge`";
    HotendFrozen, "S2", "hot end temperature stands still while it cannot",
        "check the thermistor's reading path, then `fdm acknowledge`";
    BadValues, "S5", "several values refused within a second", "see the refusals in the diagnostics";
    StaleHotend, "S7", "no hot end temperature", "restart the thermistor node; then `fdm resume` where it has paused, `fdm acknowledge` where the heaters are off";
    StaleBed, "S7", "no bed temperature", "restart the thermistor node; then `fdm resume` where it has paused, `fdm acknowledge` where the heaters are off";
    StaleEncoder, "S7", "no filament encoder", "restart the filament_encoder node";
    StalePrinter, "C13", "no printer state", "check the link to the printer, then `fdm resume` where it has paused";
    StaleCommand, "C1", "no controller command", "restart the mpc_controller node";
    StaleEstimate, "C1", "no state estimate", "restart the state_estimator node";
    HeaterStuckOn, "P1", "the hot end heats without being told to",
        "take the printer off the mains; replace the heater switch, then `fdm acknowledge`";
    HeatUnseen, "P1", "the heaters are off by order, and no reading shows whether they are",
        "take the printer off the mains; check the thermistor and its plug; power it again, then `fdm acknowledge`";
    HeaterDeficit, "P2", "the hot end heater gives too little power",
        "check heater cartridge and its wires, then `fdm acknowledge`";
    ThermistorDetached, "P3", "hot end temperature falls faster than it can cool",
        "check that the thermistor sits in the block, then `fdm acknowledge`";
    HotendNoisy, "S4", "many readings of the hot end temperature are off",
        "check the thermistor's plug and wires beside the heater's";
    HotendDrift, "S3", "the power that the hot end takes no longer fits its temperature",
        "compare the thermistor with another one; look for a draught, a lost silicone sock or a melt leak; \
         then `fdm acknowledge` where the heaters are off";
    HotendStep, "S10", "hot end temperature steps as no block can", "check the thermistor and its plug, then `fdm acknowledge`";
    BedFrozen, "P12", "bed temperature stands still while it cannot",
        "check the reading path of the bed's thermistor, then `fdm acknowledge`";
    BedStuckOn, "P12", "the bed heats without being told to", "take the printer off the mains; replace the bed's switch, then `fdm acknowledge`";
    BedDeficit, "P12", "the bed heater gives too little power", "check the bed's heater and its wires, then `fdm acknowledge`";
    BedThermistorDetached, "P12", "bed temperature falls faster than it can cool",
        "check that the thermistor sits under the bed, then `fdm acknowledge`";
    PartFan, "P4", "the part fan does not turn as told", "clear or replace the part fan; overhangs and bridges may be bad";
    StopInput, "P13", "the stop contact is open: button or door", "close it and make the printer safe, then `fdm acknowledge`";
    FilamentSlip, "P6", "the filament does not follow the motor: it slips, or has run out", "load filament if it has run out, else clear nozzle and drive gear; then `fdm resume`";
    EncoderSurplus, "P6", "the encoder reads more filament than the motor has pushed: nobody watches over slip",
        "check the encoder's wheel, its wires and its metres per count";
    RunOut, "P7", "no filament", "load filament, then `fdm resume`";
    LayerShift, "P8", "what was laid lies elsewhere than it was laid", "`fdm stop` and print anew: the lost steps are not made up for";
    Spaghetti, "P9", "the camera sees loose strands: the print may have come off", "look at the print, then `fdm resume` or `fdm stop`";
    UnderExtrusion, "P5", "the camera sees thin roads and gaps", "check nozzle and filament for a clog, then `fdm resume`";
    OverExtrusion, "P5", "the camera sees too much material", "check flow and first layer, then `fdm resume`";
    StaleImu, "S7", "no accelerations", "restart the imu node";
    StaleVision, "S7", "no report of the camera's judge", "restart the camera and defect_classifier nodes";
    EstimatorIdle, "C4", "the state_estimator beats, but estimates nothing", "restart the state_estimator node";
    ControllerIdle, "C4", "the mpc_controller beats, but plans nothing", "restart the mpc_controller node";
    CameraIdle, "C4", "the camera node beats, but passes no frame on",
        "see its diagnostics: the source is silent or its frames are refused; else restart the camera node";
    JudgeIdle, "C4", "the defect_classifier beats, but judges no frame", "restart the defect_classifier node";
    VisionBlind, "S8", "no frame could be judged for long", "clean and light the camera";
    PlanInfeasible, "K1", "the controller's plan has no solution", "see the controller's log; check its limits";
    PlanLate, "K2", "several plans in a row came too late", "take load off the machine, or make the horizon shorter";
    PlanNotFinite, "K3", "the controller's plan is not finite", "see the controller's log; restart the mpc_controller node";
    EstimateReset, "K4", "the estimate diverged and was started anew", "check the sensors' readings against the estimator's noise parameters";
    EstimateDiverging, "K4", "the estimate diverged twice within a minute", "check sensors and printer file, then `fdm mode` to set it again";
    Saturated, "K5", "an actuator has stood at its stop for long", "check heater, nozzle and filament; slow the file down";
    Envelope, "K6", "several commands outside of their limits within a second", "see the controller's log";
    Oscillation, "K7", "the corrections swing to and fro", "lower the controller's gains";
    ModelMismatch, "K8", "the printer is not the one of the parameter files", "check nozzle, filament and printer file, then `fdm mode` to set it again";
    SecondPublisher, "C8", "a second publisher of commands", "end one of the controllers";
    Confidence, "1.6", "the fused confidence of a defect is high", "look at the print, then `fdm resume` or `fdm stop`";
    PrinterFailed, "C14", "the printer gave the job up", "see the printer's own message, then `fdm acknowledge`";
    PrinterPaused, "C14", "paused by the printer itself, or before the supervisor was started", "see the printer's own message, then `fdm resume`";
    PauseTooLong, "1.6", "paused for longer than allowed", "`fdm acknowledge`, then start the job again";
    OperatorPause, "P13", "paused by a person", "`fdm resume` to go on, `fdm stop` to give the job up";
    OperatorStop, "P13", "stopped by a person", "`fdm acknowledge`, then start the next job";
    OperatorEstop, "P13", "emergency stop by a person", "make the printer safe, then `fdm acknowledge`";
    LatchUnreadable, "T5", "the record of a latched mode cannot be read",
        "find out why the last run ended, then `fdm acknowledge`";
    StandingUnreadable, "T5", "the record of mode and pause cannot be read",
        "look at the print, then `fdm resume`, and `fdm mode` for another mode";
    SecondSource, "C8", "a second publisher of a sensor, of the printer's state or of an estimate",
        "end it: `refused_..._gate` on /diagnostics names the topic, `ros2 topic info -v` who publishes it";
    HotendUnjudged, "S7", "readings of the hot end, or the printer's orders, come too seldom to judge its heater",
        "check the link to the printer and the load of this machine, then `fdm acknowledge`";
    BedUnjudged, "S7", "readings of the bed, or the printer's orders, come too seldom to judge its heater",
        "check the link to the printer and the load of this machine, then `fdm acknowledge`";
    SecondSupervisor, "C8", "a second publisher of permits", "end the other supervisor: the printer obeys one alone";
}

impl Cause {
    /// Whether the bed's thermistor or heater is at fault.
    #[must_use]
    pub fn is_of_bed(self) -> bool {
        use Cause as C;
        matches!(
            self,
            C::BedRange
                | C::StaleBed
                | C::BedFrozen
                | C::BedStuckOn
                | C::BedDeficit
                | C::BedThermistorDetached
                | C::BedUnjudged
        )
    }

    /// Whether the balance of a heater has to run before it counts as gone.
    #[must_use]
    pub fn is_of_balance(self) -> bool {
        use Cause as C;
        matches!(
            self,
            C::HeaterStuckOn
                | C::HeaterDeficit
                | C::HotendFrozen
                | C::HotendUnjudged
                | C::BedStuckOn
                | C::BedDeficit
                | C::BedFrozen
                | C::BedUnjudged
        )
    }

    /// The cause of a pause for a confidence that this defect carries.
    #[must_use]
    pub fn of_defect(defect: Option<Defect>) -> Self {
        match defect {
            Some(Defect::Spaghetti) => Self::Spaghetti,
            Some(Defect::Under) => Self::UnderExtrusion,
            Some(Defect::Over) => Self::OverExtrusion,
            Some(Defect::Shift | Defect::Stringing | Defect::Blobs | Defect::Other) | None => {
                Self::Confidence
            }
        }
    }

    /// Whether the camera's judge says it, and a person sees more.
    #[must_use]
    pub fn is_of_camera(self) -> bool {
        use Cause::{Confidence, LayerShift, OverExtrusion, Spaghetti, UnderExtrusion};
        matches!(self, LayerShift | Spaghetti | UnderExtrusion | OverExtrusion | Confidence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_is_its_own_index() {
        for (index, cause) in Cause::ALL.iter().enumerate() {
            assert_eq!(*cause as usize, index);
        }
    }

    /// Who reads "acknowledge" cannot know that it is a command, and whose.
    #[test]
    fn what_to_do_names_the_commands_it_means() {
        for cause in Cause::ALL {
            let todo = cause.what_to_do();
            assert!(!todo.is_empty(), "{cause:?}");
            for word in ["acknowledge", "resume", "stop", "set the mode"] {
                let bare = todo.replace(&format!("`fdm {word}`"), "");
                assert!(!bare.contains(word), "{cause:?}: {word} without its command: {todo}");
            }
        }
    }

    /// What latches ends by an acknowledge alone: whoever is told of it is told that too.
    #[test]
    fn what_latches_whatever_else_holds_names_the_acknowledge() {
        use Cause as C;
        for cause in [
            C::HotendRange,
            C::BedRange,
            C::HotendFrozen,
            C::BedFrozen,
            C::HeaterStuckOn,
            C::BedStuckOn,
            C::HeaterDeficit,
            C::BedDeficit,
            C::ThermistorDetached,
            C::BedThermistorDetached,
            C::HotendStep,
            C::HotendDrift,
            C::HotendUnjudged,
            C::BedUnjudged,
            C::StaleHotend,
            C::StopInput,
            C::OperatorStop,
            C::OperatorEstop,
            C::PrinterFailed,
            C::PauseTooLong,
            C::LatchUnreadable,
        ] {
            assert!(cause.what_to_do().contains("`fdm acknowledge`"), "{cause:?}");
        }
    }
}
