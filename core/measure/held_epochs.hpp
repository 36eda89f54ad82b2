#pragma once
// Epochs whose reference points were found where they had been: one set-up, unless readings say
// otherwise.

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/measure/reading.hpp"
#include "core/mechanism/nominal_machine.hpp"

namespace trammel {

/// Of each epoch that is not the first of its set-up, the first: `held` are pairs of epochs between
/// which reference points were found where they had been, in chains.
std::map<int, int> first_epochs(std::span<const std::pair<int, int>> held);

/// The readings with the first epoch of each set-up: epochs that `first` does not list stay.
void renumber(std::vector<Reading>& readings, const std::map<int, int>& first);

/// Chance of taking a set-up that held for one that moved. A resumed session has some epochs, and
/// what a fit loses by shifts of their own (two thirds of its gain, of few readings) it loses in
/// vain: the reference points have been measured already, to say that nothing moved.
inline constexpr double kFalseStepOfHeld = 1e-4;

/// The same, but of the set-ups within which readings show no step: by the variance ratio of
/// test_epochs at kFalseStepOfHeld over the measured coordinates; too few readings show none.
/// Throws as test_epochs. Proof: epochs_test.cpp, epochs_of_methods_test.cpp.
std::map<int, int> epochs_of_one_set_up(const NominalMachine& machine,
                                        std::span<const Reading> readings,
                                        std::span<const std::pair<int, int>> held);

}  // namespace trammel
