#pragma once
// What is not in the catalogue and looks like an effect that is: motion lost in proportion to the
// last move looks like backlash where moves are of nearly one length; rails that follow the
// thermometer late, or settle after the start, look like thermal growth, or like a drift.

#include <optional>

#include "core/diagnose/residual_space.hpp"
#include "core/diagnose/selection.hpp"
#include "core/diagnose/structure.hpp"

namespace trammel {

struct LookAlike {
  Finding finding;
  double evidence = 0;  // chi^2 that it gains over the effect it stands for, each less its price
};

/// The look-alike that earns most in place of one effect of `best`, on the rails that suit it, at
/// the price of an effect of the catalogue; nothing when none earns more than the effect does.
///
/// Asked only where the readings can tell the two apart: the part of the effect's fitted signal
/// that the look-alike can't imitate must carry kTellApart (chi^2). A look-alike is held to be 20
/// times rarer than the effect, so one that only fits as well is no rival.
std::optional<LookAlike> best_look_alike(const ResidualSpace& space, const Library& library,
                                         const Candidate& best);
inline constexpr double kTellApart = 6.0;

}  // namespace trammel
