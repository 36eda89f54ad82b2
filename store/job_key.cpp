#include "store/job_key.hpp"

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "store/digest.hpp"
#include "store/reading.hpp"

namespace trammel::store {

namespace {

void add(Digest& digest, const Pose& pose) { digest << pose.x_mm << pose.y_mm << pose.phi_rad; }
void add(Digest& digest, const Displacements& l_mm) { digest << l_mm[0] << l_mm[1] << l_mm[2]; }

std::string model_part(const JobKeyInput& input) {
  const Campaign& campaign = input.campaign;
  Digest digest;
  digest << canonical_json(input.model_json, "model");
  const GeometryVector geometry = to_vector(campaign.mechanism.geometry);
  for (const double value : geometry) digest << value;
  digest << campaign.mechanism.screw_lead_mm << campaign.mechanism.limits.l_min_mm
         << campaign.mechanism.limits.l_max_mm;
  add(digest, campaign.mechanism.home);
  digest << static_cast<int>(campaign.tracker.has_value());
  if (campaign.tracker) digest << campaign.tracker->xy_mm << campaign.tracker->phi_rad;
  return hex(digest.finish());
}

std::string readings_part(const std::vector<Reading>& readings) {
  Digest digest;
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
std::string list_part(const Values& values) {
  Digest digest;
  for (const auto& value : values) digest << value;
  return hex(digest.finish());
}

std::string text_part(const std::string& text) { return hex((Digest() << text).finish()); }

}  // namespace

std::string canonical_json(const std::string& text, const std::string& field) {
  try {
    return nlohmann::json::parse(text).dump();
  } catch (const nlohmann::json::exception& error) {
    throw InputError({.what = "not JSON", .where = {.field = field}, .got = error.what()});
  }
}

JobKey job_key(const JobKeyInput& input) {
  JobKey result;
  result.parts = {{"stage", text_part(input.stage)},
                  {"algorithm_version", text_part(std::to_string(input.algorithm_version))},
                  {"parameters", text_part(canonical_json(input.parameters_json, "parameters"))},
                  {"model", model_part(input)},
                  {"readings", readings_part(input.campaign.readings)},
                  {"exclusions", list_part(input.excluded_seqs)},
                  {"parents", list_part(input.parent_keys)}};
  Digest digest;
  for (const auto& [part, sha256] : result.parts) digest << part << sha256;
  result.key = hex(digest.finish());
  return result;
}

}  // namespace trammel::store
