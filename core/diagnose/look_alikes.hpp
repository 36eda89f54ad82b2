#pragma once
// What looks like an effect that the search names, and is another thing: friction that remembers
// the path, or motion lost in proportion to the move, for backlash; rails that follow the
// thermometer late, or settle after the start, for thermal growth or a drift; a tilted measuring
// plane for a scale; an error with the cube of travel for one of the lead.

#include <span>
#include <string>
#include <vector>

#include "core/diagnose/dictionary.hpp"
#include "core/diagnose/residual_space.hpp"
#include "core/diagnose/selection.hpp"
#include "core/diagnose/structure.hpp"
#include "core/model/history.hpp"

namespace trammel {

struct LookAlike {
  std::string name;  // as rivals are reported: "hysteresis", or "unnamed: …"
  Finding finding;
  double evidence = 0;  // chi^2 that it gains over the effects it stands for, each less its price
  ActiveEffect shape = {};   // the effect of the catalogue that it is, values 0; none: unnamed
  std::vector<int> effects;  // places in the catalogue: those of the best set that it stands for
  std::vector<DeviationOf> terms;  // of the rails that suit it; of a reading off the path, as if
                                   // it were measured after all of it
};

/// The best of each kind of look-alike in place of one effect of `best`, or of all those it may be
/// taken for, on the rails that suit it; by falling evidence, those within 20:1. A kind that has no
/// name is held to be 20 times rarer than the effect, friction with memory and a thermometer that
/// lags 4.5 times, a tilted plane as common.
///
/// Price: that of an effect of the catalogue; over its scales (radius, length, time, azimuth) the
/// likelihood is averaged. Asked only where the readings can tell the two apart (the part of
/// either's fitted signal that the other can't imitate carries kTellApart of chi^2), but for a
/// tilted plane, which hardly any point tells from a scale. An effect that takes part in the search
/// is no look-alike.
std::vector<LookAlike> look_alikes(const ResidualSpace& space, const Library& library,
                                   const Candidate& best, const History& history);
inline constexpr double kTellApart = 6.0;
inline constexpr double kSameSignal = 0.05;

}  // namespace trammel
