"""OSQP and do-mpc with IPOPT on the problem of `fdm bench controller`: a JSON object on standard input, one on output.

Both are written down anew from model book 1.7, not from our matrices.
"""
import json
import math
import sys
import time

import casadi
import do_mpc
import numpy as np
import osqp
import scipy.sparse as sparse

task = json.load(sys.stdin)
n, ratio = task["horizon"], task["width_ratio"]
keep_flow, keep_temp = math.exp(-task["period_s"] / task["flow_s"]), math.exp(-task["period_s"] / task["thermal_s"])
cost, low, high, rate = task["cost"], task["low"], task["high"], task["rate"]
change = [cost["change_weight"] / cost[name] ** 2 for name in ("feed_change", "speed_change", "setpoint_change_k")]
F, V, D, FLOW, TEMP, STAGE = 0, 1, 2, 3, 4, 5


def stage_cost(f, v, d, flow, temp, gain):
    """Of the deviations that these moves lead to."""
    return (
        (ratio * (flow + gain - v) / cost["width_scale"]) ** 2
        + cost["temperature_weight"] * (temp / cost["temperature_scale_k"]) ** 2
        + (v / cost["speed_scale"]) ** 2
        + (f / cost["feed_scale"]) ** 2
        + cost["setpoint_weight_1_k2"] * d**2
    )


def symbolic():
    """The quadratic problem by differentiation: its variables, and what depends on the start as parameters."""
    z = casadi.MX.sym("z", n * STAGE)
    start = casadi.MX.sym("start", 6)  # flow, temperature, gain, last f, v, d
    total, equal, between = 0, [], []
    for k in range(n):
        at = z[k * STAGE : (k + 1) * STAGE]
        flow, temp = (start[0], start[1]) if k == 0 else (z[(k - 1) * STAGE + FLOW], z[(k - 1) * STAGE + TEMP])
        equal += [at[FLOW] - keep_flow * flow - (1 - keep_flow) * at[F], at[TEMP] - keep_temp * temp - (1 - keep_temp) * at[D]]
        total += stage_cost(at[F], at[V], at[D], at[FLOW], at[TEMP], start[2])
        for i in range(3):
            step = at[i] - (start[3 + i] if k == 0 else z[(k - 1) * STAGE + i])
            total += change[i] * step**2
            between += [(at[i], low[i], high[i]), (step, -rate[i], rate[i])]
    rows = casadi.vertcat(*equal, *[row for row, _, _ in between])
    lower = np.array([0.0] * len(equal) + [least for _, least, _ in between])
    upper = np.array([0.0] * len(equal) + [most for _, _, most in between])
    zero = np.zeros(n * STAGE)
    p = casadi.Function("p", [z, start], [casadi.hessian(total, z)[0]])(zero, np.zeros(6))
    q = casadi.Function("q", [start], [casadi.substitute(casadi.gradient(total, z), z, zero)])
    a = casadi.Function("a", [z, start], [casadi.jacobian(rows, z)])(zero, np.zeros(6))
    offset = casadi.Function("offset", [start], [casadi.substitute(rows, z, zero)])
    return sparse.csc_matrix(p.sparse()), q, sparse.csc_matrix(a.sparse()), offset, lower, upper


def run_osqp(tolerance):
    p, q, a, offset, lower, upper = symbolic()
    solver = osqp.OSQP()
    solver.setup(
        sparse.triu(p, format="csc"), np.zeros(p.shape[0]), a, lower, upper, eps_abs=tolerance, eps_rel=tolerance, verbose=False, max_iter=100000
    )
    moves, spent = [], []
    for start in task["starts"]:
        shift = np.array(offset(start)).ravel()
        solver.update(q=np.array(q(start)).ravel(), l=lower - shift, u=upper - shift)
        result = solver.solve()
        # The solver's own clock: no Python in it.
        spent.append(result.info.run_time)
        moves.append(result.x[:3].tolist())
    return {"moves": moves, "solve_s": spent}


def run_do_mpc():
    model = do_mpc.model.Model("discrete")
    names = ["flow", "temp"] + [f"last_{i}" for i in range(3)]
    for name in names:
        model.set_variable("_x", name)
    for i in range(3):
        model.set_variable("_u", f"move_{i}")
    model.set_variable("_p", "gain")

    def lagged():
        x, u = model.x, model.u
        return keep_flow * x["flow"] + (1 - keep_flow) * u["move_0"], keep_temp * x["temp"] + (1 - keep_temp) * u["move_2"]

    for name, after in zip(names, (*lagged(), *(model.u[f"move_{i}"] for i in range(3)))):
        model.set_rhs(name, after)
    model.setup()
    # The symbols of a model are others once it is set up.
    after, gain = lagged(), model.p["gain"]
    move, last = [model.u[f"move_{i}"] for i in range(3)], [model.x[f"last_{i}"] for i in range(3)]
    mpc = do_mpc.controller.MPC(model)
    mpc.settings.n_horizon, mpc.settings.t_step, mpc.settings.store_full_solution = n, task["period_s"], False
    mpc.settings.nlpsol_opts = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": 0, "record_time": True, "ipopt.tol": 1e-9}
    steps = sum(change[i] * (move[i] - last[i]) ** 2 for i in range(3))
    mpc.set_objective(lterm=stage_cost(*move, *after, gain) + steps, mterm=casadi.DM(0))
    mpc.set_rterm(**{f"move_{i}": 0.0 for i in range(3)})
    for i in range(3):
        mpc.bounds["lower", "_u", f"move_{i}"], mpc.bounds["upper", "_u", f"move_{i}"] = low[i], high[i]
        mpc.set_nl_cons(f"rise_{i}", move[i] - last[i], ub=rate[i])
        mpc.set_nl_cons(f"fall_{i}", last[i] - move[i], ub=rate[i])
    now = mpc.get_p_template(1)
    mpc.set_p_fun(lambda _: now)
    mpc.setup()
    moves, spent, inner = [], [], []
    for start in task["starts"][: task["do_mpc_starts"]]:
        now["_p", 0] = start[2]
        x0 = np.array([start[0], start[1], *start[3:]]).reshape(-1, 1)
        mpc.x0 = x0
        if not moves:
            mpc.set_initial_guess()
        begin = time.perf_counter()
        u0 = mpc.make_step(x0)
        spent.append(time.perf_counter() - begin)
        inner += [mpc.solver_stats[name] for name in ("t_wall_total",) if name in mpc.solver_stats]
        moves.append(np.array(u0).ravel().tolist())
    return {"moves": moves, "solve_s": spent, "ipopt_s": inner}


told = {"osqp": {str(tolerance): run_osqp(tolerance) for tolerance in task["tolerances"]}, "do_mpc": run_do_mpc()}
print("\n" + json.dumps(told))
