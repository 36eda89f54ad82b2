#pragma once
// A station's file made again from the archive.

#include <filesystem>
#include <string>

#include "app/archive/link.hpp"
#include "store/verify.hpp"

namespace trammel::archive {

/// What is pulled of a station: all its campaigns, or the one and those whose jobs it builds on.
struct Wanted {
  std::string station;
  std::string campaign = {};  // uuid; empty: all
  bool with_results = false;  // jobs that workers computed, too, where the station has none such
};

/// Every row of the campaigns into the new file `to`, with the bits, the numbers and the seals that
/// it had; workers' jobs get numbers behind the station's, and the rows of one campaign are
/// numbered from 1; readings' chains end in the same heads. Read in one state of the archive;
/// verified whole before the file gets its name (store/refill.hpp).
/// @throws NotFoundError  the archive has nothing of this station
/// @throws InputError     the name is taken; the archive's rows are not what a station stores
/// Proof: push_pull_test.cpp
store::CheckReport pull(Link& link, const Wanted& wanted, const std::filesystem::path& to);

}  // namespace trammel::archive
