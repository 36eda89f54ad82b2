#pragma once
// What to measure next: the points that tell tied explanations apart.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/calibrate/geometry_fit.hpp"
#include "core/diagnose/dictionary.hpp"
#include "core/plane/place.hpp"

namespace trammel {

/// A signal that these readings can hardly tell from what `columns` can imitate.
struct Tie {
  struct Term {
    DeviationOf deviation;
    double value = 1;  // of the signal: as fitted; of a column, which is free: its usual size
  };
  std::vector<Term> signal;   // of the named set
  std::vector<Term> columns;  // of the rival
  std::vector<int> effects;   // places in the catalogue, of both sides
  bool by_direction = false;  // of approach: either side follows it
  bool by_length = false;     // of the last move: either side follows it
  std::string why;            // "tells backlash from lead_curvature"
  std::string instead;        // another measurement that would decide
  double lead = 0;            // of the named set in score, on the readings there are
};

/// One parameter of an effect; it adds nothing where its condition is not recorded.
Tie::Term effect_term(int effect, int parameter, double value);

struct NextPoint {
  Pose target;
  std::array<int, 3> approach = {};  // +1, -1: direction in which each rail arrives
  std::string why;
};

/// Under what the points are to be measured, where it matters.
struct NextState {
  std::optional<double> temp_degc;  // of the machine
  std::optional<double> wait_h;     // after the last reading
  double approach_mm = 5;           // length of each point's last move
};

/// A tie that no point decides, and what would.
struct Undecided {
  std::string what;     // "tells tracker_scale from lead_scale"
  std::string instead;  // "a reference length (scale bar) measured by the tracker"
};

struct NextPoints {
  std::vector<NextPoint> points;  // no two alike
  NextState state;
  std::vector<Undecided> undecided;
  double energy_before = 0;  // smallest leftover energy among the ties, chi^2 of the noise
  double energy_after = 0;
};

struct NextOptions {
  int most = 40;                   // points
  bool new_epoch = true;           // the points get joint zeros and a frame of their own
  std::vector<Place> within = {};  // convex hull; none: kNearEdge of the readings' own
};

/// Points (pose, orientation, direction and length of approach, temperature, waiting time),
/// measured after the readings, that decide as many of the ties as `most` points can (T-optimality,
/// Atkinson & Fedorov 1975: greedy, then exchange).
///
/// Candidates are a lattice over the bounds that `check` finds safe: no point is asked for where
/// the machine has not been, unless the bounds say so.
///
/// Leftover energy of a tie: |v - C b|^2 minimised over b; v the whitened signal, C the base (with
/// the new epoch's joint zeros and frame) and the rival's columns, over old and new points. One
/// more point with rows (C_c, v_c) adds d' (I + C_c N^-1 C_c')^-1 d, d = v_c - C_c b, N = C' C.
/// A tie is decided when it gains energy_needed(lead). The worst decided tie counts first; points
/// are added until all are decided. Ties that all candidates together leave below kHopeless are
/// `undecided`; so are those that the chosen points leave there.
NextPoints plan_next_points(const GeometryFit& base, const std::vector<Reading>& readings,
                            const PoseSigma& sigma, const std::vector<Tie>& ties,
                            const NextOptions& options = {});

/// Energy that new points must add so that a rival which trails by `lead` in score trails by 20:1
/// (kEvidence20To1) in 99.9 % of repetitions: the score gains E +- 2 sqrt(E), so with z = 3
///   E = (z + sqrt(z^2 + kEvidence20To1 - lead))^2
double energy_needed(double lead);
inline constexpr double kHopeless = 6;  // 20:1 in every second repetition

/// Share of what was measured, about its middle, where new points may lie: the outermost points
/// themselves show no room for the approach beyond them.
inline constexpr double kNearEdge = 0.9;

}  // namespace trammel
