#pragma once
// What a design can show at all, before any residual is looked at.

#include <optional>
#include <string>
#include <vector>

#include "core/diagnose/residual_space.hpp"

namespace trammel {

/// Two effects whose signals these readings can hardly tell apart.
struct Alias {
  std::string effect;
  double shared = 0;  // share of the signal's energy (after the base) that the other can imitate
};

struct AuditRow {
  std::string effect;
  double surviving_share = 0;  // of the whitened sum of squares that the base can't imitate
  std::optional<double>
      smallest_visible;  // of the parameter (of that unit) seen worst, at 80 % power
  double usual_max = 0;  // of the parameters of that unit
  std::string unit;
  std::vector<Alias> aliases;  // effects that share more than kAliasShare of the signal
  std::string missing;         // condition that is not recorded or does not vary
  /// Of a usual size it would not be seen.
  [[nodiscard]] bool only_unusual() const {
    return smallest_visible && *smallest_visible > usual_max;
  }
};
inline constexpr double kAliasShare = 0.95;

/// One row per effect of the catalogue that the machine can have, for the design of `space` (its
/// residual is not read).
///
/// surviving share of an effect: sum over its parameters of |M e|^2 / |e|^2, each scaled to its
/// usual size; smallest visible: value whose |M e|^2 reaches the noncentrality that chi^2(1) needs
/// for 80 % power at the structure test's level (about 3.0 + 0.84 sigmas, squared).
std::vector<AuditRow> audit_design(const ResidualSpace& space);

}  // namespace trammel
