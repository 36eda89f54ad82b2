#include "core/judge/before_after.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/judge/deviation.hpp"
#include "core/units.hpp"

namespace trammel {

std::vector<Figure> figures_of(const Machine& machine) {
  if (!machine.measured[2]) return {Figure::position_mm};
  return {Figure::position_mm, Figure::attitude_deg};
}

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

}  // namespace trammel
