#pragma once
// What a fit has seen: which targets, and under which set-ups of the machine.

#include <cstddef>
#include <optional>
#include <set>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/measure/reading.hpp"

namespace trammel {

/// Targets that differ by no more are one. A tenth of what a good tracker tells apart (10 um, and
/// 10 um over the 100 mm from the platform's centre to a joint), and more than three decimals of a
/// mm or a degree lose when a target goes through text.
inline constexpr double kSameTargetMm = 1e-3;
inline constexpr double kSameTargetRad = 1e-5;

/// One place and one orientation, whole turns aside. Proof: seen_test.cpp.
bool same_target(const Pose& a, const Pose& b);

/// Distinct targets, numbered from 0 in the order in which they were added.
class Targets {
 public:
  /// The number of this target: a new one unless it is known.
  std::size_t add(const Pose& target);
  [[nodiscard]] std::optional<std::size_t> find(const Pose& target) const;
  [[nodiscard]] std::size_t size() const { return targets_.size(); }

 private:
  using Cell = std::pair<long long, long long>;  // of kSameTargetMm: the same are in neighbours
  struct Hash {
    std::size_t operator()(const Cell& cell) const;
  };
  std::vector<Pose> targets_;
  std::unordered_map<Cell, std::vector<std::size_t>, Hash> by_cell_;
};

/// What a reading can say of a fit.
enum class Standing {
  fitted,         // the fit was made at its target: in-sample, whatever its set is called
  unseen,         // held out
  unknown_epoch,  // homed and framed anew since: how far that moved everything no fit can know
};

/// "in-sample", "held-out", "new epoch".
const char* name_of(Standing standing);

/// Epochs between which reference points were found where they had been.
using HeldEpochs = std::vector<std::pair<int, int>>;

/// What the readings that a fit took let it know.
class Seen {
 public:
  /// `taken`: readings that were fitted. An epoch is known when one of them is of it, or when the
  /// set-up held between it and one that is known. `one_set_up`: the fit took it that all epochs
  /// are one. Proof: seen_test.cpp.
  explicit Seen(std::span<const Reading> taken, const HeldEpochs& held = {},
                bool one_set_up = false);

  [[nodiscard]] bool target(const Pose& target) const { return targets_.find(target).has_value(); }
  [[nodiscard]] bool epoch(int number) const { return one_set_up_ || epochs_.contains(number); }
  /// Of a reading whose error after the correction is predicted.
  [[nodiscard]] Standing standing(const Reading& reading) const;
  /// Of a target that was measured again under the correction, so that its epoch tells itself.
  [[nodiscard]] Standing standing(const Pose& measured_again) const;

 private:
  Targets targets_;
  std::set<int> epochs_;
  bool one_set_up_ = false;
};

/// Of a fit to the identify rows of `inputs`.
Seen seen_by_fit(const Campaign& inputs, const HeldEpochs& held, bool one_set_up);

}  // namespace trammel
