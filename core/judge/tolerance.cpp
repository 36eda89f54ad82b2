#include "core/judge/tolerance.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"

namespace trammel {

const char* name_of(Conformity conformity) {
  switch (conformity) {
    case Conformity::passes:
      return "passes";
    case Conformity::fails:
      return "fails";
    default:
      return "undecided";
  }
}

Conformity conformity(double error_mm, double U_mm, double tolerance_mm) {
  if (!(std::isfinite(tolerance_mm) && tolerance_mm > 0)) {
    throw InputError({.what = "no tolerance",
                      .where = {.field = "tolerance"},
                      .got = std::to_string(tolerance_mm),
                      .expected = "mm, above 0"});
  }
  if (!(std::isfinite(U_mm) && U_mm >= 0)) {
    throw InputError({.what = "no expanded uncertainty",
                      .where = {.field = "U_mm"},
                      .got = std::to_string(U_mm),
                      .expected = "mm, 0 or more"});
  }
  if (error_mm + U_mm <= tolerance_mm) return Conformity::passes;
  return error_mm - U_mm > tolerance_mm ? Conformity::fails : Conformity::undecided;
}

Conformity conformity_of_all(std::span<const Conformity> points) {
  const auto any = [points](Conformity c) { return std::ranges::find(points, c) != points.end(); };
  if (any(Conformity::fails)) return Conformity::fails;
  return points.empty() || any(Conformity::undecided) ? Conformity::undecided : Conformity::passes;
}

}  // namespace trammel
