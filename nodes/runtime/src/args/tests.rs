use super::*;

fn parse(line: &str) -> Result<Args, ArgsError> {
    Args::parse(line.split_whitespace().map(str::to_owned))
}

#[test]
fn launch_ros_arguments_are_understood() {
    let args = parse(
        "--ros-args -r __node:=left -r __ns:=/printer_1 --params-file a.yaml --params-file b.yaml \
         -p rate_hz:=20 -p name:=x:=y --log-level debug --log-level rustdds:=ERROR -r printer/state:=other",
    )
    .unwrap();
    assert_eq!(args.node.as_deref(), Some("left"));
    assert_eq!(args.namespace.as_deref(), Some("/printer_1"));
    assert_eq!(args.params_files, [PathBuf::from("a.yaml"), PathBuf::from("b.yaml")]);
    assert_eq!(args.parameters, [("rate_hz".into(), "20".into()), ("name".into(), "x:=y".into())]);
    assert_eq!(args.log_levels, [(None, LogLevel::Debug), (Some("rustdds".into()), LogLevel::Error)]);
    assert_eq!(args.remaps, [("printer/state".into(), "other".into())]);
}

#[test]
fn a_double_dash_ends_ros_arguments() {
    let args = parse("before --ros-args -p a:=1 -- after --ros-args -p b:=2").unwrap();
    assert_eq!(args.rest, ["before", "after"]);
    assert_eq!(args.parameters.len(), 2);
}

#[test]
fn what_is_not_understood_is_named() {
    assert_eq!(parse("--ros-args --bogus").unwrap_err(), ArgsError::Unknown("--bogus".into()));
    assert_eq!(parse("--ros-args -p").unwrap_err(), ArgsError::MissingValue("-p".into()));
    let text = parse("--ros-args -p rate=3").unwrap_err().to_string();
    assert_eq!(text, "argument '-p rate=3': expected name:=value");
    assert!(matches!(parse("--ros-args --log-level loud"), Err(ArgsError::Malformed { .. })));
    let deep = |parts: usize| parse(&format!("--ros-args -p {}:=1", vec!["a"; parts].join(".")));
    assert!(deep(128).is_ok() && matches!(deep(129), Err(ArgsError::Malformed { .. })));
}

/// What `rcl` takes and means nothing here is taken, and told once.
#[test]
fn what_has_no_meaning_here_is_accepted_and_told() {
    let args = parse(
        "--ros-args -e /printer/left --log-config-file log.cfg --disable-rosout-logs --disable-stdout-logs \
         --enable-external-lib-logs --disable-external-lib-logs --enable-rosout-logs",
    )
    .unwrap();
    assert!(args.no_rosout_logs && args.no_stdout_logs);
    assert_eq!(args.remarks.len(), 2, "{:?}", args.remarks);
    assert!(args.remarks[0].starts_with("-e /printer/left: has no effect"), "{:?}", args.remarks);
    assert!(args.remarks[1].starts_with("--log-config-file log.cfg: is not read"), "{:?}", args.remarks);
    let text = parse("--ros-args --enclave printer").unwrap_err().to_string();
    assert_eq!(text, "argument '--enclave printer': expected an absolute name, as /printer");
    assert_eq!(parse("--ros-args -e").unwrap_err(), ArgsError::MissingValue("-e".into()));
}

/// A megabyte in an argument is not said again as a whole.
#[test]
fn a_refusal_is_one_line_whatever_it_refuses() {
    let long = "x".repeat(1_000_000);
    for line in [
        format!("--ros-args -p {long}"),
        format!("--ros-args {long}"),
        format!("--ros-args --log-level {long}"),
    ] {
        let text = parse(&line).unwrap_err().to_string();
        assert!(text.len() < 400 && text.contains("... (1000000 bytes)"), "{text:.500}");
    }
}
