//! System tests live in the test targets.
