#include <algorithm>

#include "core/error.hpp"
#include "core/model/effect.hpp"

namespace trammel {

std::span<const Effect> effect_catalogue() {
  static const std::vector<Effect> all = {
      lead_scale(),     lead_curvature(), screw_periodic(), backlash(),      thermal_growth(),
      axis_crosstalk(), platform_load(),  guide_bow(),      tracker_drift(), tracker_scale()};
  return all;
}

const Effect& find_effect(const std::string& name) {
  const auto all = effect_catalogue();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Effect& e) { return e.name == name; });
  if (found != all.end()) return *found;
  std::string names;
  for (const Effect& e : all) names += (names.empty() ? "" : ", ") + e.name;
  throw NotFoundError({.what = "no such effect", .got = name, .expected = "one of " + names});
}

std::vector<EffectParameter> one_per_rail(const std::string& letter, const std::string& unit,
                                          double usual_max) {
  std::vector<EffectParameter> parameters;
  for (int rail = 0; rail < kChains; ++rail) {
    parameters.push_back({letter + "_" + std::to_string(rail + 1), unit, rail, usual_max});
  }
  return parameters;
}

Deviation& Deviation::operator+=(const Deviation& other) {
  dl_mm += other.dl_mm;
  dh_mm += other.dh_mm;
  dX += other.dX;
  return *this;
}

Deviation operator*(double factor, const Deviation& d) {
  return {factor * d.dl_mm, factor * d.dh_mm, factor * d.dX};
}

std::string to_string(Need need) {
  switch (need) {
    case Need::travel:
      return "travel along the rails";
    case Need::direction:
      return "more than one direction of approach";
    case Need::temperature:
      return "a recorded temperature that changes";
    case Need::time:
      return "recorded times";
    case Need::orientation:
      return "more than one orientation";
  }
  return {};
}

}  // namespace trammel
