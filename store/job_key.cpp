#include "store/job_key.hpp"

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "store/digest.hpp"
#include "store/machine.hpp"
#include "store/reading.hpp"

namespace trammel::store {

namespace {

void add(Digest& digest, const Pose& pose) { digest << pose.x_mm << pose.y_mm << pose.phi_rad; }
void add(Digest& digest, const Displacements& l_mm) { digest << l_mm[0] << l_mm[1] << l_mm[2]; }

/// The parts of a key, by one scheme.
struct Parts {
  ByteOrder order = ByteOrder::big;

  [[nodiscard]] std::string model(const JobKeyInput& input) const {
    const Campaign& campaign = input.campaign;
    Digest digest(order);
    digest << canonical_json(input.model_json, "model");
    if (order == ByteOrder::big) {
      digest << campaign.machine;
    } else {
      const Mechanism mechanism = mechanism_of(campaign.machine);
      const GeometryVector geometry = to_vector(mechanism.geometry);
      for (const double value : geometry) digest << value;
      digest << mechanism.screw_lead_mm << mechanism.limits.l_min_mm << mechanism.limits.l_max_mm;
      add(digest, mechanism.home);
    }
    digest << static_cast<int>(campaign.tracker.has_value());
    if (campaign.tracker) digest << campaign.tracker->xy_mm << campaign.tracker->phi_rad;
    return hex(digest.finish());
  }

  [[nodiscard]] std::string readings(const std::vector<Reading>& readings) const {
    Digest digest(order);
    for (const Reading& r : readings) {
      digest << r.seq << name_of(r.set);
      add(digest, r.target);
      add(digest, r.conditions.cmd_mm);
      add(digest, r.conditions.from_mm);
      digest << r.conditions.epoch << r.conditions.time_s << r.conditions.temp_degc;
      digest << static_cast<int>(r.measured.has_value());
      if (r.measured) add(digest, *r.measured);
    }
    return hex(digest.finish());
  }

  template <class Values>
  [[nodiscard]] std::string list(const Values& values) const {
    Digest digest(order);
    for (const auto& value : values) digest << value;
    return hex(digest.finish());
  }

  [[nodiscard]] std::string text(const std::string& text) const {
    return hex((Digest(order) << text).finish());
  }
};

}  // namespace

std::string canonical_json(const std::string& text, const std::string& field) {
  try {
    return nlohmann::json::parse(text).dump();
  } catch (const nlohmann::json::exception& error) {
    throw InputError({.what = "not JSON", .where = {.field = field}, .got = error.what()});
  }
}

JobKey job_key(const JobKeyInput& input, int scheme) {
  const Parts part{scheme == kKeyScheme ? ByteOrder::big : ByteOrder::little};
  JobKey result{.scheme = scheme};
  result.parts = {{"stage", part.text(input.stage)},
                  {"algorithm_version", part.text(std::to_string(input.algorithm_version))},
                  {"parameters", part.text(canonical_json(input.parameters_json, "parameters"))},
                  {"model", part.model(input)},
                  {"readings", part.readings(input.campaign.readings)},
                  {"exclusions", part.list(input.excluded_seqs)},
                  {"parents", part.list(input.parent_keys)}};
  Digest digest(part.order);
  for (const auto& [name, sha256] : result.parts) digest << name << sha256;
  result.key = hex(digest.finish());
  return result;
}

}  // namespace trammel::store
