"""The plant of `fdm bench sim` in plain Python: a JSON object on standard input, one on output.

Model book 1.2: two heat capacities and a thermistor (exact steps, as ours), compressed filament with the melt's power
law, slip by force, a road smeared over a nozzle's width.
"""
import json
import math
import sys
import time

task = json.load(sys.stdin)
h, e, m, s = task["hotend"], task["extruder"], task["material"], task["slip"]
R_GAS = 8.314462618
area = math.pi * e["filament_diameter_m"] ** 2 / 4
index = m["flow_index"]
ambient = task["ambient_k"]


def followed(rate, lag, t):
    ratio = t / lag
    gap = ratio - rate * t
    return ratio * math.exp(-ratio) * (1.0 if abs(gap) < 1e-9 else math.expm1(gap) / gap)


def heat(block, nozzle, sensor, power, fan, melt, dt):
    block_loss, nozzle_loss = h["block_loss_w_k"] + h["block_loss_fan_w_k"] * fan, h["nozzle_loss_w_k"] + h["nozzle_loss_fan_w_k"] * fan
    k, ce, cn = h["coupling_w_k"], h["block_capacity_j_k"], h["nozzle_capacity_j_k"]
    block_sum, nozzle_sum = k + block_loss, k + nozzle_loss + melt
    block_rhs, nozzle_rhs = power + block_loss * ambient, (nozzle_loss + melt) * ambient
    det = block_sum * nozzle_sum - k * k
    block_end, nozzle_end = (block_rhs * nozzle_sum + k * nozzle_rhs) / det, (block_sum * nozzle_rhs + k * block_rhs) / det
    block_rate, nozzle_rate, to_nozzle, to_block = block_sum / ce, nozzle_sum / cn, k / cn, k / ce
    half_gap = math.sqrt(0.25 * (block_rate - nozzle_rate) ** 2 + to_nozzle * to_block)
    middle = 0.5 * (block_rate + nozzle_rate)
    slow, fast = middle - half_gap, middle + half_gap
    block_off, nozzle_off = block - block_end, nozzle - nozzle_end
    slope = -block_rate * block_off + to_block * nozzle_off
    slow_part = (slope + fast * block_off) / (fast - slow)
    fast_part = block_off - slow_part
    slow_now, fast_now = slow_part * math.exp(-slow * dt), fast_part * math.exp(-fast * dt)
    lag = h["sensor_lag_s"]
    return (
        block_end + slow_now + fast_now,
        nozzle_end + ((block_rate - slow) * slow_now + (block_rate - fast) * fast_now) / to_block,
        block_end + (sensor - block_end) * math.exp(-dt / lag) + slow_part * followed(slow, lag, dt) + fast_part * followed(fast, lag, dt),
    )


def force_scale(temp):
    """Force per u^n."""
    consistency = m["consistency_pa_sn"] * math.exp(m["activation_energy_j_mol"] / R_GAS * (1 / temp - 1 / m["reference_temp_k"]))
    shear = 4 * area / (math.pi * e["nozzle_radius_m"] ** 3)
    return 2 * e["nozzle_length_m"] * consistency / e["nozzle_radius_m"] * shear**index * area


def outlet(held, scale, warm):
    """Outlet speed and u^n at a compressed length."""
    if held <= 0.0:
        return 0.0, 0.0
    most = held / scale
    shape, speed = warm if 0.0 < warm[0] <= most else (most, most ** (1 / index))
    for _ in range(40):
        step = (held - scale * shape - e["linear_lag_s"] * speed) / (scale + e["linear_lag_s"] * speed / (index * shape))
        if abs(step) <= 1e-9 * shape:
            return shape + step, speed + speed * step / (index * shape)
        shape += step
        speed = shape ** (1 / index)
    return shape, speed


def melting(held, speed, nozzle, gain):
    """Force per u^n at the temperature of the melt that leaves where so much is held: T_m(u) and u follow from each other."""
    if held <= 0.0:
        return force_scale(nozzle)
    warmer = nozzle - ambient
    if speed <= 0.0:
        speed = outlet(held, e["compliance_m_n"] * force_scale(nozzle), (0.0, 0.0))[1]
    low, high = 0.0, math.inf
    for _ in range(60):
        turns = e["melting_flow_m3_s"] / (speed * area * gain)
        cold = math.exp(-turns)
        temp = ambient + warmer * (1.0 - cold)
        sheared = e["compliance_m_n"] * force_scale(temp) * speed**index
        cooled = m["activation_energy_j_mol"] / R_GAS / temp**2 * warmer * turns * cold
        missing = held - sheared - e["linear_lag_s"] * speed
        step = missing / ((index + cooled) * sheared / speed + e["linear_lag_s"])
        if abs(step) <= 1e-5 * speed:
            speed += step
            break
        low, high = (low, speed) if step < 0.0 else (speed, high)
        speed = speed + step if low < speed + step < high else 0.5 * (low + high)
    return force_scale(ambient + warmer * -math.expm1(-e["melting_flow_m3_s"] / (speed * area * gain)))


def run():
    block = nozzle = sensor = task["start_k"]
    held, out, fed, left, melted = 0.0, (0.0, 0.0), 0.0, 0.0, 0.0
    force = force_scale(nozzle)
    dt, spread, section = 1e-3, 2 * e["nozzle_radius_m"], None
    for k in range(task["steps"]):
        motor = task["motor_m_s"] * (1.0 + 0.5 * math.sin(1e-3 * k))
        load = force * out[0]
        slip = min(max(s["base"] + s["creep"] * (load / s["creep_force_n"]) ** 2 + s["overload"] * max(load - e["force_max_n"], 0.0) / s["overload_force_n"], 0.0), s["cap"])
        feed = (1.0 - slip) * motor
        fed += feed * dt
        force = melting(held, out[1], nozzle, task["gain"])
        scale = e["compliance_m_n"] * force
        start = outlet(held, scale, out)
        mean = 0.0
        if start[1] > 0.0:
            ratio = dt / (index * scale * start[0] / start[1] + e["linear_lag_s"])
            mean = max(feed + (start[1] - feed) * (-math.expm1(-ratio) / ratio), 0.0)
        held += (feed - mean) * dt
        left += mean * dt
        out = outlet(held, scale, start)
        flow = mean * area * task["gain"]
        melted += flow * dt
        path = task["path_m_s"] * dt
        if section is None:
            section = task["section_m2"]
        kept = math.exp(-path / spread)
        section = section * kept + flow * dt * (1 - kept) / path
        if k % 10 == 9:
            melt = m["density_kg_m3"] * melted / 0.01 * m["heat_capacity_j_kg_k"]
            melted = 0.0
            block, nozzle, sensor = heat(block, nozzle, sensor, h["heater_power_w"] * task["duty"], task["fan"], melt, 0.01)
    return {"block_k": block, "nozzle_k": nozzle, "sensor_k": sensor, "fed_m": fed, "left_m": left, "section_m2": section}


begin = time.perf_counter()
told = run()
spent = time.perf_counter() - begin
print(json.dumps({**told, "steps_1_s": task["steps"] / spent}))
