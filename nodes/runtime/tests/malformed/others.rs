//! What `fdm`, the recorder and the services read, and the time that all nodes follow: taken as it is, so that it has to
//! decode or be refused, and its stamps have to be times.

use fdm_loop_msgs::{
    Clock, GetParametersRequest, Header, Heartbeat, InjectFaultRequest, LayerQuality, ListParametersRequest,
    Parameter, ParameterValue, PrintEvent, PrintInfo, RosType, SafetyState, SetModeRequest,
    SetParametersAtomicallyRequest, SetParametersRequest, SimTruth, SimWire, Time, TriggerRequest,
};
use models::units::Seconds;

use crate::storm::{bytes_storm, is_a_stamp};

/// Each decodes or does not; what `header` finds is a time or none.
fn taken_as_it_is<T: RosType>(sound: &T, header: impl Fn(&T) -> Option<f64>) {
    bytes_storm(T::DEFINITION.name, sound, |message, number| {
        let stamp_s = header(message);
        assert!(
            stamp_s.is_none_or(|stamp_s| is_a_stamp(Seconds(stamp_s))),
            "{}: payload {number}",
            T::DEFINITION.name
        );
        stamp_s.is_some()
    });
}

fn header() -> Header {
    Header { frame_id: "hotend".to_owned(), ..Header::at(12.5) }
}

#[test]
fn time_of_the_graph() {
    taken_as_it_is(&Clock { clock: Time::from_seconds(12.5) }, |message| message.clock.seconds());
}

#[test]
fn what_is_shown_and_recorded() {
    let node = "/printer/thermistor".to_owned();
    taken_as_it_is(&Heartbeat { header: header(), node: node.clone(), ..Heartbeat::default() }, |message| {
        message.header.stamp.seconds()
    });
    let what_to_do = "look at the printer".to_owned();
    taken_as_it_is(
        &SafetyState { header: header(), what_to_do: what_to_do.clone(), ..SafetyState::default() },
        |message| message.header.stamp.seconds(),
    );
    taken_as_it_is(
        &PrintEvent { header: header(), who: node, what: what_to_do, ..PrintEvent::default() },
        |message| message.header.stamp.seconds(),
    );
    let info = PrintInfo { header: header(), config: "a: 1\n".repeat(30), ..PrintInfo::default() };
    taken_as_it_is(&info, |message| message.header.stamp.seconds());
    taken_as_it_is(&SimTruth { header: header(), ..SimTruth::default() }, |message| {
        message.header.stamp.seconds()
    });
    taken_as_it_is(&SimWire { header: header(), ..SimWire::default() }, |message| {
        message.header.stamp.seconds()
    });
    taken_as_it_is(&LayerQuality { header: header(), ..LayerQuality::default() }, |message| {
        message.header.stamp.seconds()
    });
}

#[test]
fn requests_to_services() {
    let value = ParameterValue {
        kind: ParameterValue::STRING_ARRAY,
        string_array_value: vec!["a".to_owned(); 3],
        byte_array_value: vec![1, 2, 3],
        double_array_value: vec![0.5; 4],
        ..ParameterValue::default()
    };
    let parameters = vec![Parameter { name: "stale.hotend.pause_s".to_owned(), value }; 2];
    bytes_storm("SetParameters", &SetParametersRequest { parameters: parameters.clone() }, |_, _| true);
    bytes_storm("SetAtomically", &SetParametersAtomicallyRequest { parameters }, |_, _| true);
    let names = vec!["modes.ramp_s".to_owned(), "use_sim_time".to_owned()];
    bytes_storm("GetParameters", &GetParametersRequest { names: names.clone() }, |_, _| true);
    bytes_storm("ListParameters", &ListParametersRequest { prefixes: names, depth: 2 }, |_, _| true);
    bytes_storm("SetMode", &SetModeRequest::default(), |_, _| true);
    bytes_storm("Trigger", &TriggerRequest::default(), |_, _| true);
    let fault = InjectFaultRequest { component: "hotend_heater".to_owned(), ..InjectFaultRequest::default() };
    bytes_storm("InjectFault", &fault, |_, _| true);
}
