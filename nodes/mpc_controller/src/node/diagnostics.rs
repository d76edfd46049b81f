//! What the node tells of itself in its diagnostics, and of the nozzle in its log.

use super::narrowing::Narrowing;
use crate::controller::Report;
use runtime::Diagnostics;

/// Tells what became of events and plans.
pub(super) fn show(diagnostics: &Diagnostics, narrowing: &mut Narrowing, report: &Report) {
    narrowing.follow(report.force).into_iter().for_each(|news| tracing::warn!("{news}"));
    diagnostics.set("solved", report.solved);
    diagnostics.set("fallbacks", report.fallbacks);
    diagnostics.set("softened", report.softened);
    diagnostics.set("saturated_s", format_args!("{:.1}", report.saturated_s));
    diagnostics.set("scheduled", report.scheduled);
    diagnostics.set("starved", report.starved);
    diagnostics.set("adopted", report.adopted);
    diagnostics.set("refused_ticks", report.refusals.tick.invalid + report.refusals.tick.late);
    diagnostics.set("advance_without_prediction", report.advance.without);
    diagnostics.set("advance_hurried", report.advance.hurried);
    diagnostics.set("advance_bounded", report.advance.bounded);
    diagnostics.set("advance_learnt", format_args!("{:.3}", report.advance.learnt));
    diagnostics.set("advance_learnt_index", format_args!("{:.3}", report.advance.learnt_index));
    diagnostics.set("melt_force", format_args!("{:.2}", report.force));
    diagnostics.set("flow_error", format_args!("{:.4}", report.flow_error));
    diagnostics.set("base", format_args!("{:.4}", report.base));
    diagnostics.set("gain_error", format_args!("{:.4}", report.gain_error));
    diagnostics.set("temperature_error_k", format_args!("{:.2}", report.temperature_error_k));
    diagnostics.set("shortfall_m", format_args!("{:.6}", report.shortfall_m));
}
