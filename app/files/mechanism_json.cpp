#include "app/files/mechanism_json.hpp"

#include <cmath>

#include "app/files/machine_json.hpp"
#include "app/files/numbers.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

/// Bounds that no machine leaves and the store holds.
constexpr double kLongestMm = 1e5;
constexpr double kMostLeadMm = 1e4;
constexpr double kMostDeg = 3600;

constexpr double kShortestMm = 1e-3;  // of a part or a lead

double within(const Fields& fields, const char* name, double value, double most) {
  if (!(std::abs(value) <= most)) {
    fields.refuse(name, "the number is out of all bounds",
                  number_text(-most) + " to " + number_text(most), "is the unit right?");
  }
  return value;
}

double positive_mm(Fields& fields, const char* name, double most_mm = kLongestMm) {
  const double value_mm = within(fields, name, fields.number(name), most_mm);
  if (!(value_mm > 0)) fields.refuse(name, "a length that is not positive");
  if (value_mm < kShortestMm) {
    fields.refuse(name, "a length that nothing machined has",
                  number_text(kShortestMm) + " mm and more", "is the unit right?");
  }
  return value_mm;
}

Chain read_chain(Fields& fields) {
  Chain chain;
  chain.alpha_rad = rad_from_deg(within(fields, "alpha_deg", fields.number("alpha_deg"), kMostDeg));
  chain.beta_rad = rad_from_deg(within(fields, "beta_deg", fields.number("beta_deg"), kMostDeg));
  chain.r_mm = positive_mm(fields, "r_mm");
  chain.S_mm = positive_mm(fields, "S_mm");
  chain.R_mm = positive_mm(fields, "R_mm");
  chain.h_mm = within(fields, "h_mm", fields.number("h_mm", 0), kLongestMm);
  chain.l_zero_mm = within(fields, "l_zero_mm", fields.number("l_zero_mm", 0), kLongestMm);
  fields.done();
  return chain;
}

nlohmann::ordered_json chain_json(const Chain& chain) {
  nlohmann::ordered_json json = {{"alpha_deg", exact_deg(chain.alpha_rad)},
                                 {"beta_deg", exact_deg(chain.beta_rad)},
                                 {"r_mm", chain.r_mm},
                                 {"S_mm", chain.S_mm},
                                 {"R_mm", chain.R_mm}};
  if (chain.h_mm != 0) json["h_mm"] = chain.h_mm;
  if (chain.l_zero_mm != 0) json["l_zero_mm"] = chain.l_zero_mm;
  return json;
}

Limits read_limits(Fields fields) {
  Limits limits;
  limits.l_min_mm =
      within(fields, "l_min_mm", fields.number("l_min_mm", limits.l_min_mm), kLongestMm);
  limits.l_max_mm =
      within(fields, "l_max_mm", fields.number("l_max_mm", limits.l_max_mm), kLongestMm);
  if (!(limits.l_min_mm < limits.l_max_mm)) fields.refuse("", "l_min_mm is not below l_max_mm");
  fields.done();
  return limits;
}

/// core names the field; the file and line are known here.
void validate_at(const Mechanism& mechanism, const Fields& fields) {
  try {
    validate(mechanism);
  } catch (const InputError& error) {
    ErrorText text = error.text();
    const std::string field = fields.path(text.where.field);
    text.where = fields.file().where(field);
    if (text.where.line == 0) text.where = fields.file().where(fields.path(""));
    text.where.field = field;
    throw InputError(text);
  }
}

}  // namespace

Pose read_pose(Fields fields) {
  const Pose pose{within(fields, "x_mm", fields.number("x_mm"), kLongestMm),
                  within(fields, "y_mm", fields.number("y_mm"), kLongestMm),
                  rad_from_deg(within(fields, "phi_deg", fields.number("phi_deg"), kMostDeg))};
  fields.done();
  return pose;
}

nlohmann::ordered_json pose_json(const Pose& pose) {
  return {{"x_mm", pose.x_mm}, {"y_mm", pose.y_mm}, {"phi_deg", exact_deg(pose.phi_rad)}};
}

Mechanism read_mechanism(Fields fields) {
  fields.choice("type", {"3-PRR"});
  Mechanism mechanism;
  if (fields.has("screw_lead_mm")) {
    mechanism.screw_lead_mm = positive_mm(fields, "screw_lead_mm", kMostLeadMm);
  }
  if (auto home = fields.optional_object("home")) mechanism.home = read_pose(*home);
  if (auto limits = fields.optional_object("limits")) mechanism.limits = read_limits(*limits);
  std::vector<Fields> chains = fields.objects("chains");
  if (chains.size() != kChains) fields.refuse("chains", "wrong number of chains", "three chains");
  for (std::size_t i = 0; i < kChains; ++i) {
    mechanism.geometry.chains[i] = read_chain(chains[i]);
  }
  fields.done();
  validate_at(mechanism, fields);
  return mechanism;
}

nlohmann::ordered_json mechanism_json(const Mechanism& mechanism) {
  nlohmann::ordered_json chains = nlohmann::ordered_json::array();
  for (const Chain& chain : mechanism.geometry.chains) chains.push_back(chain_json(chain));
  return {{"type", "3-PRR"},
          {"screw_lead_mm", mechanism.screw_lead_mm},
          {"home", pose_json(mechanism.home)},
          {"limits",
           {{"l_min_mm", mechanism.limits.l_min_mm}, {"l_max_mm", mechanism.limits.l_max_mm}}},
          {"chains", chains}};
}

Mechanism read_mechanism_file(const std::filesystem::path& path) {
  const Machine machine = read_machine_file(path);
  try {
    return mechanism_of(machine);
  } catch (const InputError& error) {
    ErrorText text = error.text();
    text.where.file = path.string();
    throw InputError(text);
  }
}

}  // namespace trammel
