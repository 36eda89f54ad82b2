#include "core/judge/before_after.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/judge/deviation.hpp"
#include "core/units.hpp"

namespace trammel {

double error_in(Figure figure, const Pose& pose, const Pose& target) {
  return figure == Figure::position_mm ? position_error_mm(pose, target)
                                       : deg_from_rad(attitude_error_rad(pose, target));
}

Errors errors_in(Figure figure, std::span<const BeforeAfter> points) {
  Errors errors;
  errors.before.reserve(points.size());
  errors.after.reserve(points.size());
  for (const BeforeAfter& p : points) {
    errors.before.push_back(error_in(figure, p.before, p.target));
    errors.after.push_back(error_in(figure, p.after, p.target));
  }
  errors.summary_before = summarise(errors.before);
  errors.summary_after = summarise(errors.after);
  errors.improvement_pct = improvement_pct(errors.summary_before, errors.summary_after);
  return errors;
}

double coordinate_U_mm(std::span<const double> position_mm) {
  TRAMMEL_ASSERT(!position_mm.empty());
  double squares = 0;
  for (const double e : position_mm) squares += e * e;
  return 2 * std::sqrt(squares / (2 * static_cast<double>(position_mm.size())));
}

Expanded expanded_from(std::span<const Pose> errors) {
  std::vector<double> position_mm;
  double phi = 0;
  for (const Pose& e : errors) {
    position_mm.push_back(position_error_mm(e, {}));
    phi += e.phi_rad * e.phi_rad;
  }
  return {.U_mm = coordinate_U_mm(position_mm),
          .U_rad = 2 * std::sqrt(phi / static_cast<double>(errors.size()))};
}

}  // namespace trammel
