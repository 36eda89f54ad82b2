#pragma once
// What to measure next: the points that tell tied explanations apart.

#include <array>
#include <string>
#include <vector>

#include "core/calibrate/geometry_fit.hpp"

namespace trammel {

/// A signal that these readings can't tell from what `columns` can imitate.
struct Tie {
  struct Term {
    int effect = 0;  // place in the catalogue
    int parameter = 0;
    double value = 0;  // of the signal; columns ignore it
  };
  std::vector<Term> signal;   // of the named set, as fitted
  std::vector<Term> columns;  // of the rival: free to take any value
  std::string why;            // "tells backlash from lead_curvature"
};

struct NextPoint {
  Pose target;
  std::array<int, 3> approach = {};  // +1, -1: direction in which each rail arrives
  std::string why;
};

struct NextPoints {
  std::vector<NextPoint> points;
  std::vector<std::string> undecided;  // ties that no reachable point decides
  double energy_before =
      0;  // smallest leftover energy among the ties, chi^2 at the readings' noise
  double energy_after = 0;
};

/// Points (pose, orientation, direction of approach), measured after the readings and in a new
/// epoch, that maximise the smallest leftover energy among the ties (T-optimality, Atkinson &
/// Fedorov 1975).
///
/// Leftover energy of a tie: |v - C b|^2 minimised over b; v the whitened signal, C the base (with
/// the new epoch's joint zeros and frame) and the rival's columns, over old and new points. One
/// more point with rows (C_c, v_c) adds d' (I + C_c N^-1 C_c')^-1 d, d = v_c - C_c b, N = C' C.
/// Greedy, until every tie has kDecided or `most` points are planned.
NextPoints plan_next_points(const GeometryFit& base, const std::vector<Reading>& readings,
                            const TrackerSigma& sigma, const std::vector<Tie>& ties, int most = 20);
inline constexpr double kDecided = 40;  // a rival then loses by 20:1 in 99 % of repetitions

}  // namespace trammel
