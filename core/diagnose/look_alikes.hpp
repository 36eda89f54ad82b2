#pragma once
// What is not in the catalogue and looks like an effect that is, on the same rails: motion lost in
// proportion to the last move looks like backlash where moves are of nearly one length.

#include <optional>

#include "core/diagnose/residual_space.hpp"
#include "core/diagnose/selection.hpp"
#include "core/diagnose/structure.hpp"

namespace trammel {

struct LookAlike {
  Finding finding;
  double evidence = 0;  // chi^2 that it gains over the effect it stands for
};

/// The look-alike that fits better in place of one effect of `best` than that effect does, with the
/// same number of parameters, on the same rails; nothing when none does.
///
/// Asked only where the readings can tell the two apart: the part of the effect's fitted signal
/// that the look-alike can't imitate must carry kTellApart (chi^2). A look-alike is held to be 20
/// times rarer than the effect, so one that only fits as well is no rival.
std::optional<LookAlike> best_look_alike(const ResidualSpace& space, const Library& library,
                                         const Candidate& best);
inline constexpr double kTellApart = 6.0;

}  // namespace trammel
