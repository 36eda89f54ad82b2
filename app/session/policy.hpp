#pragma once
// What a session does about devices that fail, rooms that change and calls that hang.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>

#include "app/device/device.hpp"

namespace trammel::session {

/// How often a point is tried, by what went wrong.
struct RetryRule {
  device::Status status;
  int tries;  // with this failure; 1: never again
};
std::span<const RetryRule> retry_rules();
int tries_for(device::Status status);

struct Policy {
  double gate_mm = 20;           // measured against commanded; beyond it everything stops
  double retry_wait_s = 2;       // before a point is tried again
  double beam_patience_s = 300;  // how long a try waits for the reflector to be locked again

  // Bad conditions are waited out: below low or above high. Good again only `hysteresis_k` inside.
  std::optional<double> low_degc = {};
  std::optional<double> high_degc = {};
  double hysteresis_k = 0.5;
  int base_every = 0;       // points between two measurements of the tracker's base nests; 0: none
  int reference_every = 0;  // points between two visits of the reference points; 0: at a resume
  double drift_mm = 0.05;   // of a reference point or a base nest; good again within half of it
  double patience_s = 3600;
  double poll_s = 30;
};

/// Throws UsageError that names the option: not finite, negative, a band without room.
void validate(const Policy& policy);

nlohmann::json policy_json(const Policy& policy);
/// What is absent has its default: sessions of earlier versions have none.
Policy read_policy(const nlohmann::json& json);

/// How long a call of a device may take before it counts as hung.
struct Deadlines {
  double home_s = 600;
  double move_s = 60;  // beside twice the travel
  double measure_s = 180;
  double ask_s = 30;  // thermometer, beam
  double stop_s = 10;
};

}  // namespace trammel::session
