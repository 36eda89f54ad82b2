#include "app/session/policy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "app/session/written.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace trammel::session {

namespace {

using device::Status;

constexpr std::array<RetryRule, 6> kRules = {{
    {Status::beam_broken, 3},
    {Status::timeout, 3},
    {Status::unstable, 5},
    {Status::limit, 1},
    {Status::following_error, 1},
    {Status::fault, 1},
}};

struct Number {
  const char* key;
  double Policy::*value;
  double least;  // above this, or equal where `from`
  bool from;
};
constexpr std::array<Number, 6> kNumbers = {{
    {"retry_wait_s", &Policy::retry_wait_s, 0, true},
    {"beam_patience_s", &Policy::beam_patience_s, 0, true},
    {"hysteresis_k", &Policy::hysteresis_k, 0, true},
    {"drift_mm", &Policy::drift_mm, 0, false},
    {"patience_s", &Policy::patience_s, 0, true},
    {"poll_s", &Policy::poll_s, 0, false},
}};

/// May be absent.
struct OptionalNumber {
  const char* key;
  std::optional<double> Policy::*value;
};
constexpr std::array<OptionalNumber, 4> kOptional = {{{"gate_mm", &Policy::gate_mm},
                                                      {"gate_deg", &Policy::gate_deg},
                                                      {"low_degc", &Policy::low_degc},
                                                      {"high_degc", &Policy::high_degc}}};

/// The smallest of what lies between neighbours and is no rest, `most` where there is none.
class Smallest {
 public:
  Smallest(double rest, double most) : rest_(rest), least_(most) {}
  void add(double value) {
    if (value > rest_) least_ = std::min(least_, value);
  }
  [[nodiscard]] double value() const { return least_; }

 private:
  double rest_, least_;
};

}  // namespace

PoseGate pose_gate(const Policy& policy, const Plan& plan, const std::optional<TrackerSigma>& sigma,
                   const std::optional<Pose>& home) {
  constexpr double kShare = 0.4, kSixOfDifference = 6 * 1.41421356237309505, kFirstMm = 5,
                   kRestMm = 0.1;
  constexpr double kMostDeg = 2, kFirstDeg = 3, kRestDeg = 0.05;
  Smallest way_mm(kRestMm, kMostGateMm / kShare), turn_deg(kRestDeg, kMostDeg / kShare);
  for (std::size_t k = 1; k < plan.points.size(); ++k) {
    const Pose &a = plan.points[k - 1].target, &b = plan.points[k].target;
    way_mm.add(std::hypot(b.x_mm - a.x_mm, b.y_mm - a.y_mm));
    turn_deg.add(std::abs(deg_from_rad(b.phi_rad - a.phi_rad)));
  }
  PoseGate gate;
  gate.stated_xy = policy.gate_mm.has_value();
  gate.stated_phi = policy.gate_deg.has_value();
  const double noise_mm = sigma ? kSixOfDifference * sigma->xy_mm : 0;
  const double noise_deg = sigma ? kSixOfDifference * deg_from_rad(sigma->phi_rad) : 0;
  gate.xy_mm = policy.gate_mm.value_or(std::max(kShare * way_mm.value(), noise_mm));
  double first_mm = std::max(gate.xy_mm, kFirstMm);
  double first_deg = std::max(kFirstDeg, noise_deg);
  if (home && !plan.points.empty()) {
    const Pose& first = plan.points.front().target;
    const double from_mm = std::hypot(first.x_mm - home->x_mm, first.y_mm - home->y_mm);
    const double from_deg = std::abs(deg_from_rad(first.phi_rad - home->phi_rad));
    if (from_mm > kRestMm) {
      first_mm = std::min(first_mm, std::max({kShare * from_mm, kFirstLeastMm, noise_mm}));
    } else if (from_deg > kRestDeg) {
      first_deg =
          std::min(first_deg, std::max({kShare * from_deg, deg_from_rad(kLashRad), noise_deg}));
    }
  }
  gate.first_xy_mm = policy.gate_mm.value_or(first_mm);
  gate.phi_rad =
      rad_from_deg(policy.gate_deg.value_or(std::max(kShare * turn_deg.value(), noise_deg)));
  gate.first_phi_rad = rad_from_deg(policy.gate_deg.value_or(first_deg));
  return gate;
}

std::span<const RetryRule> retry_rules() { return kRules; }

int tries_for(Status status) {
  for (const RetryRule& rule : kRules) {
    if (rule.status == status) return rule.tries;
  }
  return 1;
}

void validate(const Policy& policy) {
  const auto refuse = [](const std::string& field, const std::string& expected) {
    throw UsageError({.what = "this cannot be held to",
                      .where = {.field = field},
                      .got = {},
                      .expected = expected});
  };
  for (const Number& n : kNumbers) {
    const double value = policy.*n.value;
    if (std::isfinite(value) && (n.from ? value >= n.least : value > n.least)) continue;
    refuse(n.key, n.from ? "0 or more" : "more than 0");
  }
  for (const auto& [key, value] :
       {std::pair("gate_mm", policy.gate_mm), std::pair("gate_deg", policy.gate_deg)}) {
    if (value && !(std::isfinite(*value) && *value > 0)) refuse(key, "more than 0");
  }
  if (policy.reference_every < 0) refuse("reference_every", "0 or more points");
  if (policy.base_every < 0) refuse("base_every", "0 or more points");
  for (const auto& limit : {policy.low_degc, policy.high_degc}) {
    if (limit && !std::isfinite(*limit)) refuse("temperature", "finite limits");
  }
  if (policy.low_degc && policy.high_degc &&
      !(*policy.low_degc + policy.hysteresis_k < *policy.high_degc - policy.hysteresis_k)) {
    refuse("temperature", "a band that is wider than twice the hysteresis");
  }
}

nlohmann::json policy_json(const Policy& policy) {
  nlohmann::json json;
  for (const Number& n : kNumbers) json[n.key] = policy.*n.value;
  json["reference_every"] = policy.reference_every;
  json["base_every"] = policy.base_every;
  for (const OptionalNumber& n : kOptional) {
    if (policy.*n.value) json[n.key] = *(policy.*n.value);
  }
  return json;
}

Policy read_policy(const nlohmann::json& json) {
  Policy policy;
  for (const Number& n : kNumbers) policy.*n.value = json.value(n.key, policy.*n.value);
  policy.reference_every = json.value("reference_every", 0);
  policy.base_every = json.value("base_every", 0);
  for (const OptionalNumber& n : kOptional) {
    if (json.contains(n.key)) policy.*n.value = json.at(n.key).get<double>();
  }
  return policy;
}

Policy read_policy(Fields fields, const Policy& absent) {
  Policy policy = absent;
  for (const Number& n : kNumbers) policy.*n.value = fields.number(n.key, absent.*n.value);
  for (const OptionalNumber& n : kOptional) {
    if (fields.has(n.key)) policy.*n.value = fields.number(n.key);
  }
  policy.reference_every = fields.integer("reference_every", absent.reference_every);
  policy.base_every = fields.integer("base_every", absent.base_every);
  fields.done();
  try {
    validate(policy);
  } catch (const UsageError& error) {
    const std::string& field = error.text().where.field;
    const bool band = field == "temperature";
    fields.refuse(band ? (fields.has("low_degc") ? "low_degc" : "high_degc") : field,
                  error.text().what, error.text().expected);
  }
  return policy;
}

}  // namespace trammel::session
