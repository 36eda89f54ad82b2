#pragma once
// Accuracy and repeatability of positioning of each rail by ISO 230-2.
//
// The formulas were checked against published data, the conditions (5 targets, 5 runs) are general
// knowledge: to be checked against the standard before anyone certifies by them.

#include <optional>
#include <span>
#include <vector>

#include "core/judge/iso_symbol.hpp"
#include "core/measure/reading.hpp"
#include "core/mechanism/machine.hpp"

namespace trammel {

/// One target position of a rail: the deviations x_ij of its runs, mm.
struct RailTarget {
  double position_mm = 0;
  std::vector<double> up, down;  // approached with growing, with falling displacement
};

/// One direction's figures: R = max 4 s_i, E = max - min of the means, A = max(x + 2 s) - min(x - 2
/// s).
struct OneWay {
  double R_mm = 0, E_mm = 0, A_mm = 0;
};

/// Both directions together, with xm_i the mean and s_i the standard deviation of a target's runs:
///   B_i = xm_i(u) - xm_i(d), B = max |B_i|, Bm = mean B_i
///   R = max_i max(2 s_i(u) + 2 s_i(d) + |B_i|, 4 s_i(u), 4 s_i(d))
///   E = max(xm(u), xm(d)) - min(same), M = max - min of (xm_i(u) + xm_i(d)) / 2
///   A = max(xm + 2 s) - min(xm - 2 s) over both directions
struct BothWays {
  double B_mm = 0, Bm_mm = 0, R_mm = 0, E_mm = 0, M_mm = 0, A_mm = 0;
};

/// Reversal and drift of one target, whatever the standard asks of the whole: over its visits,
///   x_k = xm_dir + d (k - mean k) + e_k,    k = 1, 2, … in each direction: the number of the run
/// by least squares: B = xm(u) - xm(d), d the drift a run, the same both ways; their standard
/// errors from the residuals, n_u + n_d - 3 degrees of freedom. s without the drift taken out.
struct Reversal {
  double position_mm = 0;
  int n_up = 0, n_down = 0;
  std::optional<double> s_up_mm, s_down_mm;  // of two runs or more
  struct Fit {
    double B_mm = 0, B_error_mm = 0, drift_mm = 0, drift_error_mm = 0;
  };
  std::optional<Fit> fit;  // of two runs or more each way
};
/// Proof: iso230_test.cpp.
Reversal reversal_at(const RailTarget& target);

/// Preconditions: some targets, two runs or more of each, in the direction asked for.
OneWay iso230_one_way(std::span<const RailTarget> targets, bool up);
BothWays iso230_both_ways(std::span<const RailTarget> targets);

/// The targets of each rail among `readings`: those whose target pose displaces one rail alone from
/// home (a target at home belongs to the rail measured before it), and that what is measured
/// locates. The rail's deviation is the
/// nominal inverse kinematics of the measured pose less that of the target pose, the position the
/// rail was to take: without compensation that is the command.
struct RailTargets {
  int rail = 0;  // from 1
  int n_epochs = 1;
  std::vector<RailTarget> targets;  // by rising position
};
std::vector<RailTargets> rail_targets(const Machine& machine, std::span<const Reading> readings);

inline constexpr int kLeastTargets = 5;  // and five on each metre
inline constexpr int kLeastRuns = 5;

struct Iso230 {
  int rail = 0;  // from 1; 0: no rail was measured alone
  int n_targets = 0;
  int least_runs = 0;  // of a target in a direction that was measured
  double travel_mm = 0;
  /// B, Bm, R_u, R_d, R, E_u, E_d, E, M, A_u, A_d, A; or refused in words.
  std::vector<IsoSymbol> symbols;
  std::vector<Reversal> reversals;  // target by target
};

/// Symbols of every rail that was measured alone; one entry with rail = 0 and all symbols refused
/// when none was. `sigma` gives floors: what a perfect robot reads of each symbol (add_floors),
/// since the deviation takes in the readings' noise of x, y and phi. Throws InputError when a
/// measured pose is out of nominal reach. Proof: iso230_test.cpp, golden numbers by
/// scripts/make_golden_iso.py.
std::vector<Iso230> iso230(const Machine& machine, std::span<const Reading> readings,
                           const std::optional<TrackerSigma>& sigma = {});
inline std::vector<Iso230> iso230(const Mechanism& mechanism, std::span<const Reading> readings,
                                  const std::optional<TrackerSigma>& sigma = {}) {
  return iso230(machine_of(mechanism), readings, sigma);
}

}  // namespace trammel
