#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/model/effect.hpp"

namespace trammel {

std::span<const Effect> effect_catalogue() {
  static const std::vector<Effect> all = {
      lead_scale(), lead_curvature(), screw_periodic(), backlash(),       move_memory(),
      hysteresis(), thermal_growth(), lagged_growth(),  axis_crosstalk(), platform_load(),
      guide_bow(),  guide_yaw(),      tracker_drift(),  tracker_scale()};
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
                                          double usual_max, On on) {
  std::vector<EffectParameter> parameters;
  for (int rail = 0; rail < kChains; ++rail) {
    parameters.push_back({letter + "_" + std::to_string(rail + 1), unit, rail, usual_max});
    parameters.back().on = on;
  }
  return parameters;
}

bool is_shape(const Effect& effect, int k) {
  const On on = effect.parameters[static_cast<std::size_t>(k)].on;
  return on == On::shape || on == On::choice;
}

Eigen::VectorXd usual_shapes(const Effect& effect) {
  Eigen::VectorXd shapes =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(effect.parameters.size()));
  for (int k = 0; k < shapes.size(); ++k) {
    const EffectParameter& p = effect.parameters[static_cast<std::size_t>(k)];
    if (is_shape(effect, k)) shapes[k] = std::sqrt(p.usual_min * p.usual_max);
  }
  return shapes;
}

bool exists(const Effect& effect, int k, const Machine& machine) {
  const EffectParameter& p = effect.parameters[static_cast<std::size_t>(k)];
  const MachineKind& kind = *machine.kind;
  if (p.rail >= kind.n_chains) return false;
  switch (p.on) {
    case On::drive:
    case On::reading:
      return true;
    case On::guide:
      return kind.chain->offset && kind.n_chains > 1;
    case On::passive:
      return kind.chain->on_guide != nullptr && kind.n_chains > 1;
    case On::platform:
      return !kind.has_point_platform();
    case On::coordinate:
      return machine.measured[static_cast<std::size_t>(k)];
    case On::shape:
    case On::choice:
      return false;
  }
  return false;
}

bool exists(const Effect& effect, const Machine& machine) {
  for (int k = 0; k < static_cast<int>(effect.parameters.size()); ++k) {
    if (exists(effect, k, machine)) return true;
  }
  return false;
}

void require_effect(const Effect& effect, const Machine& machine) {
  if (exists(effect, machine)) return;
  std::string names;
  for (const Effect& e : effect_catalogue()) {
    if (exists(e, machine)) names += (names.empty() ? "" : ", ") + e.name;
  }
  throw InputError({.what = "a machine of kind " + std::string(machine.kind->name) +
                            " has nothing that this effect acts on",
                    .where = {.field = "effects"},
                    .got = effect.name,
                    .expected = "one of " + names});
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

std::string sentence_of(const Effect& effect, const Machine& machine,
                        const std::vector<int>& rails) {
  const On on = effect.parameters.front().on;
  if (!machine.kind->has_point_platform() || (on != On::guide && on != On::passive)) {
    return effect.sentence;
  }
  std::string all;
  for (const int rail : rails) {
    const std::string guide = guide_name(machine, rail), drive = drive_name(machine, rail);
    const char along = guide.front(), across = drive.front();
    all += all.empty() ? "the " : "; the ";
    if (on == On::guide) {
      all += guide + " is bent: " + across + " errs with the square of " + along;
    } else {
      all += drive + " yaws as it travels: " + across + " errs with " + across + " times " + along +
             ", the lever arm (Abbe)";
    }
  }
  return all;
}

std::string to_string(Need need) {
  switch (need) {
    case Need::travel:
      return "travel of the drives";
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
