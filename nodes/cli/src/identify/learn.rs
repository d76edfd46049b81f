//! From readings to numbers with intervals.

use super::flow::{self, Flow, FlowFit, Nominal};
use super::gains::Gains;
use super::heat::{self, Heat, HeatFit};
use super::params::IdentifyParams;
use super::record::{At, Recorded};
use anyhow::Context;
use models::extruder::Extruder;
use models::material::Material;
use models::melt::Melt;
use models::printer::Printer;
use models::units::Kelvin;
use nalgebra::{DMatrix, Matrix3x2, Vector2, Vector3};
use serde::Serialize;

/// Half width of a 95 % interval in standard deviations.
const WIDE: f64 = 1.96;

/// A learned number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Quantity {
    /// As the parameter files call it, where they do.
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) value: f64,
    /// 95 % interval.
    pub(super) low: f64,
    pub(super) high: f64,
    /// What the files say.
    pub(super) before: f64,
    /// `bag`, or `belief` where the bag says little: the interval is not much narrower than it was before.
    pub(super) source: &'static str,
    /// What only a simulation knows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) truth: Option<f64>,
}

/// What was learned from a bag.
#[derive(Debug, Clone)]
pub(super) struct Learned {
    pub(super) heat: HeatFit,
    pub(super) flow: Option<FlowFit>,
    pub(super) quantities: Vec<Quantity>,
}

/// Names and units of the hot end's numbers, in the order of the parameters.
const HEAT: [(&str, &str); heat::COUNT] = [
    ("hotend.block_capacity_j_k", "J/K"),
    ("hotend.nozzle_capacity_j_k", "J/K"),
    ("hotend.coupling_w_k", "W/K"),
    ("hotend.block_loss_w_k", "W/K"),
    ("hotend.nozzle_loss_w_k", "W/K"),
    ("hotend.block_loss_fan_w_k", "W/K"),
    ("hotend.nozzle_loss_fan_w_k", "W/K"),
    ("hotend.sensor_lag_s", "s"),
    ("material.heat_capacity_j_kg_k", "J/(kg K)"),
    ("ambient_k", "K"),
];

/// Lag at the three speeds of the file.
const LAGS: [&str; 3] = ["lag_slow_s", "lag_s", "lag_fast_s"];

/// Fits heat and flow in turn: the melt cools the nozzle, and the nozzle's temperature is the melt's.
pub(super) fn learn(
    recorded: &Recorded,
    (printer, material): (&Printer, &Material),
    params: &IdentifyParams,
    with_flow: bool,
) -> anyhow::Result<Learned> {
    let area_m2 = printer.extruder.filament_area_m2();
    let mut volume_m3: Vec<At> =
        recorded.fed_m().into_iter().map(|(at_s, fed_m)| (at_s, fed_m * area_m2)).collect();
    let (mut heat, mut flow): (Option<HeatFit>, Option<FlowFit>) = (None, None);
    // No width tells the section: what is not known of it makes the hot end's intervals wider.
    let believed = (!with_flow).then(|| Gains::believed(&recorded.fed_m(), params));
    for _ in 0..params.fit.rounds {
        let known = flow.as_ref().map(|flow| flow.gains.clone()).or_else(|| believed.clone());
        let problem = Heat::new(recorded, (&volume_m3, known.as_ref()), (printer.hotend, material), params)
            .context("no readings of the hot end")?;
        let fitted = problem
            .fit(heat.as_ref().map(|heat| &heat.fit))
            .context("the readings of the hot end have no unique answer")?;
        let problem = Flow::new(recorded, &fitted, (printer.extruder, material), params);
        if with_flow {
            let found = problem
                .fit(flow.as_ref().map(|flow| &flow.fit))
                .context("no widths of steady roads, or none with a unique answer")?;
            volume_m3.clone_from(&found.volume_m3);
            flow = Some(found);
        } else {
            volume_m3 = problem.by_files().context("no flow by the files")?;
        }
        heat = Some(fitted);
    }
    let heat = heat.context("no round")?;
    let mut quantities = of_heat(&heat, (printer, material), params);
    if let Some(flow) = &flow {
        let of_flow = of_flow(flow, params);
        quantities
            .extend(of_flow.context("compliance and linear lag are one: the material's flow_index is 1")?);
    }
    quantities.extend(of_noise(recorded, &heat, flow.as_ref()));
    Ok(Learned { heat, flow, quantities })
}

impl Learned {
    /// What its own fit tells against it: more is left than noise leaves.
    pub(super) fn doubts(&self, misfit_max: f64) -> Vec<String> {
        let of_heat = ("hot end", "thermistor", self.heat.fit.variance);
        let of_flow = self.flow.as_ref().map(|flow| ("flow", "widths", flow.fit.variance));
        let told = |(part, sensor, misfit): (&str, &str, f64)| {
            format!(
                "identify: what the fit of the {part} leaves is {:.1} times the noise of the {sensor}, {:.1} at most where \
                 nothing else acts: a draught, a fault, another spool",
                misfit.sqrt(),
                misfit_max.sqrt()
            )
        };
        [Some(of_heat), of_flow]
            .into_iter()
            .flatten()
            .filter(|(.., misfit)| *misfit > misfit_max)
            .map(told)
            .collect()
    }
}

/// A number that is `before` times the exponential of a parameter.
fn of_logarithm(
    (name, unit): (&'static str, &'static str),
    before: f64,
    (parameter, variance): (f64, f64),
    (prior, informed): (f64, f64),
) -> Quantity {
    let deviation = variance.sqrt();
    let value = |shift: f64| before * (parameter + shift).exp();
    Quantity {
        name,
        unit,
        value: value(0.0),
        low: value(-WIDE * deviation),
        high: value(WIDE * deviation),
        before,
        source: if deviation < informed * prior { "bag" } else { "belief" },
        truth: None,
    }
}

fn of_heat(
    heat: &HeatFit,
    (printer, material): (&Printer, &Material),
    params: &IdentifyParams,
) -> Vec<Quantity> {
    let nominal = *printer.hotend;
    let before = [
        nominal.block_capacity_j_k,
        nominal.nozzle_capacity_j_k,
        nominal.coupling_w_k,
        nominal.block_loss_w_k,
        nominal.nozzle_loss_w_k,
        heat::lossy(nominal.block_loss_fan_w_k),
        heat::lossy(nominal.nozzle_loss_fan_w_k),
        nominal.sensor_lag_s,
        material.heat_capacity_j_kg_k,
        heat.ambient_k - heat.fit.parameters[heat::AMBIENT],
    ];
    let prior = heat::prior(&params.prior);
    let quantity = |place: usize| {
        let (parameter, variance) = (heat.fit.parameters[place], heat.fit.covariance[(place, place)]);
        if place == heat::AMBIENT {
            let wide = WIDE * variance.sqrt();
            let (low, high) = (heat.ambient_k - wide, heat.ambient_k + wide);
            let (name, unit) = HEAT[place];
            let (value, before) = (heat.ambient_k, before[place]);
            return Quantity { name, unit, value, low, high, before, source: "bag", truth: None };
        }
        of_logarithm(HEAT[place], before[place], (parameter, variance), (prior[place], params.fit.informed))
    };
    (0..heat::COUNT).map(quantity).collect()
}

fn of_flow(flow: &FlowFit, params: &IdentifyParams) -> Option<Vec<Quantity>> {
    let speeds = params.fit.lag_speeds_m_s;
    let before_s = lags_of_file(&flow.extruder, &flow.material, &flow.nominal, speeds);
    let straight = |name, unit, (value, variance): (f64, f64), before, prior: f64| {
        let wide = WIDE * f64::sqrt(variance);
        let source = if variance.sqrt() < params.fit.informed * prior { "bag" } else { "belief" };
        Quantity { name, unit, value, low: value - wide, high: value + wide, before, source, truth: None }
    };
    let mut quantities: Vec<Quantity> = (0..3)
        .map(|row| {
            let found = (flow.lags_s[row], flow.lags_covariance[(row, row)]);
            straight(LAGS[row], "s", found, before_s[row], params.prior.compression_rel * before_s[row])
        })
        .collect();
    let (law, covariance) = as_filed(flow, &flow.held_m)?;
    let compliance = (law[0], covariance[(0, 0)]);
    let (before, prior) = (flow.extruder.compliance_m_n, params.prior.compression_rel);
    quantities.push(straight("extruder.compliance_m_n", "m/N", compliance, before, prior * before));
    let linear = (law[1], covariance[(1, 1)]);
    let (before, prior) = (flow.extruder.linear_lag_s, params.prior.linear_lag_rel);
    quantities.push(straight("extruder.linear_lag_s", "s", linear, before, prior * before));
    let place = flow::FLOW_INDEX;
    let index = flow.material.flow_index;
    let found = (index + flow.fit.parameters[place], flow.fit.covariance[(place, place)]);
    quantities.push(straight("material.flow_index", "-", found, index, params.prior.flow_index));
    Some(quantities)
}

/// Lag that files say at the speeds `[s]`.
pub(super) fn lags_of_file(
    extruder: &Extruder,
    material: &Material,
    nominal: &Nominal,
    speeds_m_s: [f64; 3],
) -> [f64; 3] {
    let force_slope = force_slopes(extruder, material, nominal, speeds_m_s);
    force_slope.map(|slope| extruder.compliance_m_n * slope + extruder.linear_lag_s)
}

/// `dF/du` by the files `[N s/m]`.
fn force_slopes(
    extruder: &Extruder,
    material: &Material,
    nominal: &Nominal,
    speeds_m_s: [f64; 3],
) -> [f64; 3] {
    let melt = Melt::new(material, extruder);
    speeds_m_s.map(|speed_m_s| {
        let flow_m3_s = extruder.filament_area_m2() * speed_m_s;
        material.flow_index * melt.force_n(flow_m3_s, Kelvin(nominal.at_k)) / speed_m_s
    })
}

/// Compliance and linear lag that hold as much filament at the speeds as was learned, with the melt of the material's file:
/// what the file of a printer has to say so that both files together are right. And their covariance.
///
/// Lags alone do not tell it: the same slopes go with other lengths where the flow index is another, and what starts a road
/// or ends it is the whole length. `None` for a melt whose force is in proportion to its speed, as the linear lag is.
pub(super) fn as_filed(flow: &FlowFit, held_m: &[f64; 3]) -> Option<(Vector2<f64>, DMatrix<f64>)> {
    let speeds_m_s = flow.speeds_m_s;
    let melt = Melt::new(&flow.material, &flow.extruder);
    let forces_n = speeds_m_s.map(|speed_m_s| {
        melt.force_n(flow.extruder.filament_area_m2() * speed_m_s, Kelvin(flow.nominal.at_k))
    });
    // In shares of what is held, so that the slow speed counts as much.
    let design = Matrix3x2::from_fn(|row, column| {
        (if column == 0 { forces_n[row] } else { speeds_m_s[row] }) / held_m[row]
    });
    let inverse = (design.transpose() * design).try_inverse()? * design.transpose();
    let spread = DMatrix::from_fn(2, 3, |row, column| inverse[(row, column)] / held_m[column]);
    let covariance = &spread * &flow.held_covariance * spread.transpose();
    Some((inverse * Vector3::from_element(1.0), covariance))
}

/// A standard deviation out of `count` residuals is known to one over the root of twice their number.
fn of_noise(recorded: &Recorded, heat: &HeatFit, flow: Option<&FlowFit>) -> Vec<Quantity> {
    let deviation = |name, unit, value: f64, (count, alike): (usize, f64), before| {
        #[allow(clippy::cast_precision_loss, reason = "a count of readings")]
        let wide = WIDE * value * (alike / (2.0 * count as f64)).sqrt();
        let (low, high) = (value - wide, value + wide);
        Quantity { name, unit, value, low, high, before, source: "bag", truth: None }
    };
    let counted = (heat.readings, heat.fit.alike);
    let mut quantities = vec![deviation("thermistor.sigma_k", "K", heat.sigma_k, counted, f64::NAN)];
    if let Some(flow) = flow {
        let counted = (flow.widths, flow.fit.alike);
        quantities.push(deviation("width.sigma_min_m", "m", flow.sigma_m, counted, f64::NAN));
    }
    if let Some(value) = quantum_m(&recorded.encoder_m) {
        let (name, unit, before) = ("encoder.quantum_m", "m", f64::NAN);
        let (low, high) = (value, value);
        quantities.push(Quantity { name, unit, value, low, high, before, source: "bag", truth: None });
    }
    quantities
}

/// Smallest step of a count that steps `[m]`.
fn quantum_m(positions_m: &[At]) -> Option<f64> {
    let steps = positions_m.windows(2).map(|pair| pair[1].1 - pair[0].1).filter(|step_m| *step_m > 1e-9);
    steps.min_by(f64::total_cmp)
}
