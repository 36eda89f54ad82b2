#include "core/mechanism/geometry.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/mechanism/machine.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

std::array<GeometryParameter, kGeometryParameters> make_parameters() {
  std::array<GeometryParameter, kGeometryParameters> all;
  const auto& of_machine = parameters_of(*find_machine_kind("3-PRR"));
  std::ranges::transform(of_machine, all.begin(), [](const MachineParameter& p) {
    return GeometryParameter{p.name, p.chain, p.is_angle, p.tolerance};
  });
  return all;
}

void require(bool ok, double value, const std::string& field, const std::string& expected) {
  if (ok) return;
  throw InputError({.what = "the mechanism is not usable",
                    .where = {.field = field},
                    .got = std::to_string(value),
                    .expected = expected});
}

}  // namespace

const std::array<GeometryParameter, kGeometryParameters>& geometry_parameters() {
  static const auto parameters = make_parameters();
  return parameters;
}

GeometryVector to_vector(const Geometry& geometry) {
  GeometryVector v;
  for (int i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[static_cast<std::size_t>(i)];
    v.segment<6>(6 * i) << c.alpha_rad, c.beta_rad, c.r_mm, c.S_mm, c.l_zero_mm, c.R_mm;
    v[kPaperParameters + i] = c.h_mm;
  }
  return v;
}

Geometry from_vector(const GeometryVector& v) {
  Geometry geometry;
  for (int i = 0; i < kChains; ++i) {
    geometry.chains[static_cast<std::size_t>(i)] = {
        v[6 * i],     v[6 * i + 1], v[6 * i + 2],           v[6 * i + 3],
        v[6 * i + 4], v[6 * i + 5], v[kPaperParameters + i]};
  }
  return geometry;
}

Mechanism paper_mechanism() {
  Mechanism mechanism;
  for (std::size_t i = 0; i < kChains; ++i) {
    const double turn_deg = 120.0 * static_cast<double>(i);
    mechanism.geometry.chains[i] = {.alpha_rad = rad_from_deg(i == 0 ? 270.0 : turn_deg - 90.0),
                                    .beta_rad = rad_from_deg(30.0 + turn_deg),
                                    .r_mm = 100,
                                    .S_mm = 430,
                                    .l_zero_mm = 0,
                                    .R_mm = 733,
                                    .h_mm = 0};
  }
  return mechanism;
}

void validate(const Mechanism& mechanism) {
  const GeometryVector values = to_vector(mechanism.geometry);
  for (int k = 0; k < kGeometryParameters; ++k) {
    const auto& name = geometry_parameters()[static_cast<std::size_t>(k)].name;
    require(std::isfinite(values[k]), values[k], name, "a finite number");
    const bool positive = name[0] == 'r' || name[0] == 'S' || name[0] == 'R';
    require(!positive || values[k] > 0, values[k], name + " (mm)", "a positive length");
  }
  require(std::isfinite(mechanism.screw_lead_mm) && mechanism.screw_lead_mm > 0,
          mechanism.screw_lead_mm, "screw_lead_mm", "a positive length");
  require(mechanism.home.vector().allFinite(), mechanism.home.x_mm, "home", "a finite pose");
  require(mechanism.limits.l_min_mm < mechanism.limits.l_max_mm, mechanism.limits.l_max_mm,
          "limits.l_max_mm", "more than l_min_mm");
}

}  // namespace trammel
