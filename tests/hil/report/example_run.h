// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>

namespace pipewright::hil {

/// run.json of a mission that went well.
inline nlohmann::ordered_json ExampleRun() {
  return nlohmann::ordered_json::parse(R"({
    "scenario": "pipes3", "seed": 4, "planner": "cfnbv", "stop_reason": "complete",
    "stop_detail": "", "sim_time_s": 241.5, "wall_time_s": 33.1,
    "voxels": {"total": 17576, "free": 17230, "occupied": 346, "unknown": 0, "residual": 0,
               "covered": 340},
    "coverage": {"truth_surface": 340, "truth_coverable": 340, "truth_covered": 334,
                 "ratio": 0.98235},
    "entropy": {"visual": 0.3644, "coverage": 0.0045, "combined": 0.3689},
    "contacts": 0, "touched": [],
    "min_clearance_m": {"plane": 0.0943698, "pipe": 0.0568905, "self": 0.029111},
    "svfi": {"mode": "exact", "alpha": 0.7, "checked": 1000, "held": 1000, "ratio": 1.0,
             "fallbacks": 0, "out_of_reach": 0},
    "control": {"rate_hz": 100.0, "cycles": 24150, "heap_allocations": 0, "rows_max": 89,
                "qp_iterations_max": 11, "qp_cap_hits": 0,
                "qp_us": {"p50": 9.5, "p99": 31.0, "max": 210.0},
                "cycle_us": {"p50": 16.6, "p99": 65.9, "max": 20148.1},
                "lateral_speed_max_mps": 7.79e-14, "joint_limit_excess_rad": -0.0303,
                "joint_hard_stops": 0},
    "plan": {"steps": 135, "stalls": 0, "step_ms": {"p50": 12.6, "p99": 55.6, "max": 56.3}},
    "path": {"base_m": 30.7, "joint_rad": 722.97},
    "localization": {"error_max_m": 0.0038, "error_max_deg": 0.46},
    "can": {"tx": 515969, "rx": 702031, "dropped": 0, "load_peak": 0.172777}
  })");
}

/// A line of plan.jsonl.
inline nlohmann::ordered_json ExampleStep(int step) {
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(R"({
    "t_s": 8.134, "step": 1, "decision": "goal",
    "goal": {"id": 11, "p_WS": [0.186, 0.628, 0.528], "z_WS": [-0.614, -0.563, -0.552],
             "waypoints": 5},
    "candidates": 160, "reachable": 6, "paths_tried": 2,
    "gain": {"visual": 39.509, "coverage": 0.0, "weighted": 29.632}, "duration_s": 1.343,
    "left": {"unknown": 17332, "uncovered": 0, "given_up": 0, "residual_new": 0}
  })");
  json["step"] = step;
  json["t_s"] = 8.0 + step;
  return json;
}

}  // namespace pipewright::hil
