#include "core/judge/seen.hpp"

#include <cmath>
#include <cstdint>

#include "core/judge/deviation.hpp"

namespace trammel {

bool same_target(const Pose& a, const Pose& b) {
  return position_error_mm(a, b) <= kSameTargetMm && attitude_error_rad(a, b) <= kSameTargetRad;
}

std::size_t Targets::Hash::operator()(const Cell& cell) const {
  constexpr std::uint64_t kOdd = 0x9e3779b97f4a7c15;  // 2^64 over the golden ratio
  const std::uint64_t mixed = static_cast<std::uint64_t>(cell.first) * kOdd;
  return static_cast<std::size_t>((mixed ^ (mixed >> 32)) +
                                  static_cast<std::uint64_t>(cell.second)) *
         kOdd;
}

std::optional<std::size_t> Targets::find(const Pose& target) const {
  const long long x = std::llround(target.x_mm / kSameTargetMm);
  const long long y = std::llround(target.y_mm / kSameTargetMm);
  std::optional<std::size_t> first;
  for (long long i = x - 1; i <= x + 1; ++i) {
    for (long long j = y - 1; j <= y + 1; ++j) {
      const auto cell = by_cell_.find({i, j});
      if (cell == by_cell_.end()) continue;
      for (const std::size_t k : cell->second) {
        if (same_target(targets_[k], target) && (!first || k < *first)) first = k;
      }
    }
  }
  return first;
}

std::size_t Targets::add(const Pose& target) {
  if (const auto known = find(target)) return *known;
  targets_.push_back(target);
  by_cell_[{std::llround(target.x_mm / kSameTargetMm), std::llround(target.y_mm / kSameTargetMm)}]
      .push_back(targets_.size() - 1);
  return targets_.size() - 1;
}

const char* name_of(Standing standing) {
  switch (standing) {
    case Standing::fitted:
      return "in-sample";
    case Standing::unseen:
      return "held-out";
    case Standing::unknown_epoch:
      return "new epoch";
  }
  return "";
}

Seen::Seen(std::span<const Reading> taken, const HeldEpochs& held, bool one_set_up)
    : one_set_up_(one_set_up) {
  for (const Reading& reading : taken) {
    targets_.add(reading.target);
    epochs_.insert(reading.conditions.epoch);
  }
  for (bool grows = true; grows;) {  // over chains of epochs
    const std::size_t before = epochs_.size();
    for (const auto& [a, b] : held) {
      if (epochs_.contains(a)) epochs_.insert(b);
      if (epochs_.contains(b)) epochs_.insert(a);
    }
    grows = epochs_.size() > before;
  }
}

Standing Seen::standing(const Reading& reading) const {
  return epoch(reading.conditions.epoch) ? standing(reading.target) : Standing::unknown_epoch;
}

Standing Seen::standing(const Pose& measured_again) const {
  return target(measured_again) ? Standing::fitted : Standing::unseen;
}

Seen seen_by_fit(const Campaign& inputs, const HeldEpochs& held, bool one_set_up) {
  std::vector<Reading> taken;
  for (const Reading& r : inputs.readings) {
    if (r.set == ReadingSet::identify && r.measured) taken.push_back(r);
  }
  return Seen(taken, held, one_set_up);
}

}  // namespace trammel
