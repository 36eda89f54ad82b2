#include "app/session/policy.hpp"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.hpp"

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
constexpr std::array<Number, 7> kNumbers = {{
    {"gate_mm", &Policy::gate_mm, 0, false},
    {"retry_wait_s", &Policy::retry_wait_s, 0, true},
    {"beam_patience_s", &Policy::beam_patience_s, 0, true},
    {"hysteresis_k", &Policy::hysteresis_k, 0, true},
    {"drift_mm", &Policy::drift_mm, 0, false},
    {"patience_s", &Policy::patience_s, 0, true},
    {"poll_s", &Policy::poll_s, 0, false},
}};

}  // namespace

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
  if (policy.low_degc) json["low_degc"] = *policy.low_degc;
  if (policy.high_degc) json["high_degc"] = *policy.high_degc;
  return json;
}

Policy read_policy(const nlohmann::json& json) {
  Policy policy;
  for (const Number& n : kNumbers) policy.*n.value = json.value(n.key, policy.*n.value);
  policy.reference_every = json.value("reference_every", 0);
  policy.base_every = json.value("base_every", 0);
  if (json.contains("low_degc")) policy.low_degc = json.at("low_degc").get<double>();
  if (json.contains("high_degc")) policy.high_degc = json.at("high_degc").get<double>();
  return policy;
}

}  // namespace trammel::session
