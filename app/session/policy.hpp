#pragma once
// What a session does about devices that fail, rooms that change and calls that hang.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>

#include "app/device/device.hpp"
#include "core/plan/plan.hpp"
#include "core/units.hpp"

namespace trammel::session {

/// How often a point is tried, by what went wrong.
struct RetryRule {
  device::Status status;
  int tries;  // with this failure; 1: never again
};
std::span<const RetryRule> retry_rules();
int tries_for(device::Status status);

struct Policy {
  // Measured against commanded; beyond it everything stops. Absent: as PoseGate.
  std::optional<double> gate_mm = {};
  std::optional<double> gate_deg = {};
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

/// How far a platform may be measured from where it was sent, before it is taken for another pose
/// (of the point before, of exchanged nests) or for a robot that is lost.
///
/// As stated (`gate_mm`, `gate_deg`), from the target; else, from the target plus the deviation of
/// the stored point nearest to it, which a robot not yet calibrated shares,
///   0.4 s + 0.02 d,   s the smallest way between neighbours in the plan; d the distance of that
///                     point
///   0.4 t + 0.02 |turn to it|,  t the smallest turn between neighbours, 2 deg at most
/// and for the first point 5 mm (0.4 s where that is more) and 3 deg, but no more than 0.4 of the
/// way, or else of the turn, from home to it, where the platform is measured when an answer is old
/// (and no less than kFirstLeastMm and kLashRad). Never more than 20 mm, never less than six sigma
/// of a difference. A simulated tracker sees no other pose than it is asked
/// for: there 0.4 s and 0.4 t are no less than kLashMm and kLashRad, which a robot's lash may need
/// where steps are small. Proof: tests/app/session/pose_gate_test.cpp.
inline constexpr double kGateSlope = 0.02;  // mm per mm of distance, rad per rad of turn
inline constexpr double kMostGateMm = 20;
inline constexpr double kFirstLeastMm = 1;  // a robot not yet calibrated is off by so much
inline constexpr double kLashMm = 0.5;
inline constexpr double kLashRad = rad_from_deg(0.25);
struct PoseGate {
  double xy_mm = 0;
  double phi_rad = 0;
  double first_xy_mm = 0;  // while nothing is stored
  double first_phi_rad = 0;
  bool stated_xy = false;  // by the policy
  bool stated_phi = false;
};
/// `home`: where the platform stands before the first point; nothing where that can't be measured
/// for it.
PoseGate pose_gate(const Policy& policy, const Plan& plan, const std::optional<TrackerSigma>& sigma,
                   const std::optional<Pose>& home = {});

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
