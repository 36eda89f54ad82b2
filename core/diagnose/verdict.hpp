#pragma once
// What may be said of the readings: nothing is missing, this is, one of these is, or something
// without a name.

#include <vector>

#include "core/diagnose/ties.hpp"
#include "core/diagnose/work.hpp"

namespace trammel {

/// Fills in verdict, effects, rivals and structure of `w.out`; `ties`: what points may decide.
void decide(Work& w, std::vector<Tie>& ties);

/// Wires, signs, frames or units are wrong: nothing is fitted, and no effect is named.
void leave_to_the_screen(Work& w);

}  // namespace trammel
