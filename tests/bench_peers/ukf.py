"""FilterPy's unscented filter on the problem of `fdm bench estimator`: a JSON object on standard input, one on output.

Both sides draw the sigma points anew before every measurement, as ours does.
"""
import json
import math
import sys
import time

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

task = json.load(sys.stdin)


def printer(x, dt, drive, c):
    """Six states of the printer: model book 1.5, two Euler steps of heat, the flow's lag exactly."""
    block, nozzle, sensor, flow, slip, gain = x
    heater_w, motor_m_s, fan = drive
    block_loss = c["block_loss_w_k"] + c["block_loss_fan_w_k"] * fan
    nozzle_loss = c["nozzle_loss_w_k"] + c["nozzle_loss_fan_w_k"] * fan
    melt = c["melt_j_k_m"] * max(flow, 0.0)
    ambient = c["ambient_k"]
    count = max(math.ceil(dt / c["substep_s"] - 1e-9), 1)
    step = dt / count
    for _ in range(count):
        across = c["coupling_w_k"] * (block - nozzle)
        block_rate = (heater_w - across - block_loss * (block - ambient)) / c["block_capacity_j_k"]
        nozzle_rate = (across - nozzle_loss * (nozzle - ambient) - melt * (nozzle - ambient)) / c["nozzle_capacity_j_k"]
        sensor_rate = (block - sensor) / c["sensor_lag_s"]
        block, nozzle, sensor = block + step * block_rate, nozzle + step * nozzle_rate, sensor + step * sensor_rate
    filament = (1.0 - slip) * motor_m_s
    flow = filament + (flow - filament) * math.exp(-dt / c["lag_s"])
    return np.array([block, nozzle, sensor, flow, slip, gain])


def ring(x):
    """Ten states that pull on their neighbours."""
    after = np.concatenate((x[1:], x[:1]))
    return x + 0.05 * (0.3 * after - 0.05 * after * after * after - 0.5 * x)


def filter_of(case, n, m):
    points = MerweScaledSigmaPoints(n, alpha=case["alpha"], beta=case["beta"], kappa=case["kappa"])
    ukf = UnscentedKalmanFilter(n, m, case.get("dt", 1.0), None, None, points)
    ukf.x, ukf.P = np.array(case["mean"]), np.diag(case["variance"])
    ukf.Q = np.diag(case["noise"])
    return ukf, points


def run_printer(case):
    ukf, points = filter_of(case, 6, 1)
    c = case["constants"]
    observe = (
        lambda x, **_: np.array([x[2]]),
        lambda x, motor_m_s, **_: np.array([(1.0 - x[4]) * motor_m_s]),
        lambda x, **_: np.array([max(x[3], 0.0) * x[5] * c["area_m2"] / (c["path_m_s"] * c["height_m"]) + c["height_m"] * (1 - math.pi / 4)]),
    )
    noises = [np.array([[value]]) for value in case["measurement_noise"]]
    begin = time.perf_counter()
    for drive, values in zip(case["drives"], case["values"]):
        ukf.predict(dt=case["dt"], fx=printer, drive=drive, c=c)
        for hx, noise, value in zip(observe, noises, values):
            ukf.sigmas_f = points.sigma_points(ukf.x, ukf.P)
            ukf.update(np.array([value]), R=noise, hx=hx, motor_m_s=drive[1])
    return ukf, time.perf_counter() - begin


def run_ring(case):
    ukf, points = filter_of(case, 10, 6)
    noise = np.diag(case["measurement_noise"])
    begin = time.perf_counter()
    for values in case["values"]:
        ukf.predict(fx=lambda x, dt: ring(x))
        ukf.sigmas_f = points.sigma_points(ukf.x, ukf.P)
        ukf.update(np.array(values), R=noise, hx=lambda x: x[:6] + 0.1 * x[4:10] ** 2)
    return ukf, time.perf_counter() - begin


told = {}
for name, run in (("printer", run_printer), ("ring", run_ring)):
    run(task[name])
    ukf, spent = run(task[name])
    told[name] = {"mean": ukf.x.tolist(), "covariance": ukf.P.tolist(), "step_s": spent / len(task[name]["values"])}
print(json.dumps(told))
