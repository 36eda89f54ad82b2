#pragma once
// What drives and rails may remember of a campaign: the path they came, the temperatures they had.

#include <array>
#include <map>
#include <span>
#include <vector>

#include "core/measure/reading.hpp"

namespace trammel {

/// Of all rows in the order they were commanded, failed and unseen ones too.
///
/// The play operator of radius r (Krasnosel'skii & Pokrovskii 1989), from home in each epoch:
///   F <- max(l - r, min(l + r, F)),   l = from_1, cmd_1, from_2, …
/// The temperature behind a lag of first order, from the first record on, linear in between:
///   tau dF/dt = T - F
/// A reading that is not of the campaign comes from home, its temperature from the last record. A
/// model without a history takes moves for long ones, and temperatures to have been steady. Proof:
/// tests/core/model/history_test.cpp.
class History {
 public:
  History(const Machine& machine, std::vector<Reading> path);

  /// Mean over the radii (octaves of kRadiiMm, from the least to the largest) of (l - F_r) / r: 1
  /// once a play is taken up in + direction, -1 in -.
  [[nodiscard]] Displacements taken(const Conditions& at, double least_mm, double largest_mm) const;

  /// At a reading whose time and temperature are recorded. On a grid of lags, cubic in ln tau.
  [[nodiscard]] double late_degc(const Conditions& at, double tau_s) const;

  /// What the thermometer showed `delay_s` earlier, the first record before all of them.
  [[nodiscard]] double delayed_degc(const Conditions& at, double delay_s) const;

  static constexpr std::array<double, 6> kRadiiMm = {1, 2, 4, 8, 16, 32};
  static constexpr int kLags = 26;
  /// From 30 s, half an octave each: less than 1e-3 of the lag is lost in between.
  static double lag_s(int place);

 private:
  using Plays = std::array<Displacements, kRadiiMm.size()>;  // F of each radius
  struct Record {
    double time_s = 0, temp_degc = 0;
    std::array<double, kLags> late_degc = {};
  };
  [[nodiscard]] double behind(const Record& last, const Conditions& at, int lag) const;

  Displacements home_mm_;
  std::map<std::vector<double>, Plays> plays_;  // by what tells readings apart: epoch, time, move
  std::vector<Record> records_;                 // by time
};

}  // namespace trammel
