#include "core/diagnose/next_points.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/diagnose/selection.hpp"
#include "core/linear/decompositions.hpp"
#include "core/linear/singular_values.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/plan/check.hpp"
#include "core/plane/extent.hpp"
#include "core/plane/hull.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kOtherApproachesMm[] = {20, 1};  // beside the usual: long, and short, moves
constexpr double kSetUpS = 900;                   // from the last reading to the first new one
constexpr double kWaitH = 4;                      // a time that tells a trend from a state
constexpr double kWarmerK = 5;                    // what a hall or a warm-up can do
constexpr double kSafeMargin = 0.15;              // of the singularity measure
constexpr double kWeakPrior = 1e-8;    // keeps N regular where the readings there are say nothing
constexpr double kIndependent = 1e-9;  // share of the largest singular value that is no rounding
const std::vector<double> kTurnsDeg = {0, -4, 4};
const std::vector<double> kMoreTurnsDeg = {0, -4, 4, -8, 8};
constexpr std::size_t kMostTies = 8;  // searched for at once: those that stand first, the closest
constexpr std::size_t kFirst = 12, kMore = 4;  // points to begin with, and those added at a time

struct Visit {
  Pose target;
  std::array<int, 3> approach;
  Conditions conditions;
};

/// Whether the platform can be measured there from any direction: the stroke that the approach
/// needs is kept free, as is a wider margin to singularities than a plan must have.
bool safe(const Machine& machine, const Pose& pose, double approach_mm) {
  const double margin_mm = approach_mm + CheckOptions{}.limit_margin_mm;
  const Plan one{"", approach_mm, {{.seq = 1, .target = pose}}};
  return check(one, machine, {.limit_margin_mm = margin_mm, .singularity_margin = kSafeMargin})
      .empty();
}

/// What was measured, drawn in to kNearEdge about the middle of its extent.
std::vector<Place> bounds_of(const std::vector<Reading>& readings) {
  std::vector<Place> places;
  for (const Reading& r : readings) places.push_back({r.target.x_mm, r.target.y_mm});
  const Extent all = extent(places);
  const Place middle{(all.low.x_mm + all.high.x_mm) / 2, (all.low.y_mm + all.high.y_mm) / 2};
  for (Place& p : places) {
    p = {middle.x_mm + kNearEdge * (p.x_mm - middle.x_mm),
         middle.y_mm + kNearEdge * (p.y_mm - middle.y_mm)};
  }
  return convex_hull(places);
}

/// The lead of the axis along `direction` (0: x, 1: y) of a point platform; 0 where there is none.
double lead_along_mm(const Machine& machine, int direction) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(machine.kind->n_chains); ++i) {
    const double alpha_rad = machine.chains[i][0];
    const double along = direction == 0 ? std::cos(alpha_rad) : std::sin(alpha_rad);
    if (machine.kind->has_point_platform() && along * along > 0.5) return machine.drives[i].lead_mm;
  }
  return 0;
}

/// Poses of a lattice over `bounds` at several orientations; that of a point platform meets its
/// screws at phases of all kinds, where even steps of whole turns would meet one. With
/// `by_direction` each from all directions; else each from one, in turn, so that the next session
/// is blind to none.
std::vector<Visit> candidates(const Machine& machine, const std::vector<Place>& bounds,
                              const Conditions& there, double approach_mm, bool by_direction) {
  const int half = by_direction ? 2 : 3;  // lattice points to either side
  const Extent all_of = extent(bounds);
  const auto at_step = [&](double low, double high, int k, int direction) {
    constexpr double kGolden = 0.618;  // its multiples, less whole turns, are spread evenly
    const double step = (high - low) / 2 / half, turns = kGolden * std::abs(k);
    const double inwards =
        std::min(lead_along_mm(machine, direction) * (turns - std::floor(turns)), step / 2);
    return (low + high) / 2 + step * k - (k > 0 ? inwards : -inwards);
  };
  std::vector<Place> places;
  for (int ix = -half; ix <= half; ++ix) {
    for (int iy = -half; iy <= half; ++iy) {
      const Place place{at_step(all_of.low.x_mm, all_of.high.x_mm, ix, 0),
                        at_step(all_of.low.y_mm, all_of.high.y_mm, iy, 1)};
      if (inside(bounds, place)) places.push_back(place);
    }
  }
  std::vector<Visit> all;
  int turn = 0;
  const int rails = machine.kind->n_chains, directions = 1 << rails;
  const std::vector<double> level = {deg_from_rad(machine.home.phi_rad)};
  const auto& turns_deg = machine.kind->has_point_platform() ? level
                          : by_direction                     ? kTurnsDeg
                                                             : kMoreTurnsDeg;
  for (const double phi_deg : turns_deg) {
    for (const Place& place : distinct_places(places)) {
      const Pose pose{place.x_mm, place.y_mm, rad_from_deg(phi_deg)};
      if (!safe(machine, pose, approach_mm)) continue;
      const Displacements at_mm = drives_of(machine, pose);
      ++turn;
      for (int bits = 0; bits < directions; ++bits) {
        if (!by_direction && bits != turn % directions) continue;
        Visit c{pose, {}, there};
        c.conditions.cmd_mm = c.conditions.from_mm = at_mm;
        for (int rail = 0; rail < rails; ++rail) {
          const int direction = bits >> rail & 1 ? 1 : -1;
          c.approach[static_cast<std::size_t>(rail)] = direction;
          c.conditions.from_mm[rail] -= direction * approach_mm;
        }
        all.push_back(c);
      }
    }
  }
  return all;
}

/// One reading as the ties see it, whitened.
struct Seen {
  Reading reading;
  Prediction at;
  Eigen::Matrix3Xd base;  // what base and epochs can imitate
};

class Design {
 public:
  Design(const GeometryFit& base, const PoseSigma& sigma, std::vector<FreeParameter> parameters)
      : base_(base),
        parameters_(std::move(parameters)),
        inverse_sigma_(sigma.of(base.model.nominal.measured).cwiseInverse()) {}

  [[nodiscard]] Seen seen(const Conditions& conditions) const {
    Seen s;
    s.reading.conditions = conditions;
    s.at = moment_of(base_.model, conditions);
    s.base = derivative(base_.model, parameters_, conditions, s.at, inverse_sigma_);
    return s;
  }
  [[nodiscard]] Eigen::Vector3d effect(const Seen& s, const Tie::Term& term) const {
    const Eigen::Vector3d moved = response(s.at, term.deviation(s.reading, s.at.moment));
    return term.value * moved.cwiseProduct(inverse_sigma_);
  }

 private:
  const GeometryFit& base_;
  std::vector<FreeParameter> parameters_;
  Eigen::Vector3d inverse_sigma_;
};

/// Rows of one reading for one tie: what is free to imitate, and the signal.
struct Rows {
  Eigen::Matrix3Xd columns;
  Eigen::Vector3d signal;
};

Rows rows_of(const Design& design, const Tie& tie, const Seen& s) {
  const Eigen::Index n = s.base.cols();
  Rows rows{Eigen::Matrix3Xd(3, n + static_cast<Eigen::Index>(tie.columns.size())),
            Eigen::Vector3d::Zero()};
  rows.columns.leftCols(n) = s.base;
  for (std::size_t k = 0; k < tie.columns.size(); ++k) {
    rows.columns.col(n + static_cast<Eigen::Index>(k)) = design.effect(s, tie.columns[k]);
  }
  for (const Tie::Term& term : tie.signal) rows.signal += design.effect(s, term);
  return rows;
}

/// Least squares of the signal on the columns, one reading after the other.
struct Imitation {
  Eigen::MatrixXd N;  // columns' columns
  Eigen::MatrixXd inverse;
  Eigen::VectorXd moment;
  double energy = 0;  // signal' signal
  Eigen::VectorXd b;

  void add(const Rows& rows, double sign = 1) {
    add_gram(N, rows.columns, sign);
    moment += sign * transposed_times(rows.columns, rows.signal);
    energy += sign * rows.signal.squaredNorm();
  }
  void solve() {
    inverse = inverse_symmetric(N);
    b = times(inverse, moment);
  }
  [[nodiscard]] double leftover() const { return std::max(0.0, energy - moment.dot(b)); }
  [[nodiscard]] double gain(const Rows& rows) const {
    const Eigen::Vector3d d = rows.signal - times(rows.columns, b);
    const Eigen::Matrix3d C =
        Eigen::Matrix3d::Identity() + rows_product(product(rows.columns, inverse), rows.columns);
    return d.dot(solve_symmetric(C, d));
  }
};

/// A tie in a search: what it has, needs, and would gain from each candidate.
struct Open {
  const Tie* tie = nullptr;
  Imitation fit;
  std::vector<Rows> rows;  // by candidate
  double before = 0;       // leftover energy of the readings there are
  double needed = 0;       // energy to add
  double most = 0;         // leftover energy with every candidate measured once

  [[nodiscard]] double progress(double more = 0) const {
    return (fit.leftover() + more - before) / needed;
  }
};

/// In place of the columns an orthonormal basis of what they span over all rows, in place of the
/// signal what that basis leaves of it: the same leftover energies, without their cancellation.
void reduce(std::vector<Rows>& all) {
  const Eigen::Index n = all.front().columns.cols();
  const auto m = static_cast<Eigen::Index>(3 * all.size());
  Eigen::MatrixXd A(std::max(m, n), n + 1);
  A.setZero();
  for (std::size_t i = 0; i < all.size(); ++i) {
    A.block(static_cast<Eigen::Index>(3 * i), 0, 3, n) = all[i].columns;
    A.block<3, 1>(static_cast<Eigen::Index>(3 * i), n) = all[i].signal;
  }
  const SingularValues svd = singular_values(A.leftCols(n));
  const Eigen::VectorXd& s = svd.singular;
  const Eigen::Index rank = (s.array() > kIndependent * s[0]).count();
  Eigen::MatrixXd T = svd.V.leftCols(rank);
  for (Eigen::Index k = 0; k < rank; ++k) T.col(k) /= s[k];
  const Eigen::VectorXd b = transposed_times(product(A.leftCols(n), T), A.col(n));
  for (Rows& rows : all) {
    rows.columns = product(rows.columns, T);
    rows.signal -= times(rows.columns, b);
  }
}

class Search {
 public:
  explicit Search(std::vector<Open> ties)
      : ties_(std::move(ties)), taken_(ties_.front().rows.size()) {}

  [[nodiscard]] const std::vector<Open>& ties() const { return ties_; }
  [[nodiscard]] std::size_t candidates() const { return taken_.size(); }
  [[nodiscard]] bool taken(std::size_t candidate) const { return taken_[candidate]; }

  void put(std::size_t candidate, bool in) {
    taken_[candidate] = in;
    for (Open& open : ties_) {
      open.fit.add(open.rows[candidate], in ? 1 : -1);
      open.fit.solve();
    }
  }
  /// How far the worst tie is decided, 1 and more: it is.
  [[nodiscard]] double worst() const {
    double least = INFINITY;
    for (const Open& open : ties_) least = std::min(least, open.progress());
    return least;
  }
  /// The free candidate after which the worst tie is decided furthest; the others break ties among
  /// candidates.
  [[nodiscard]] std::size_t best() const {
    std::size_t place = 0;
    double best_value = -INFINITY;
    for (std::size_t c = 0; c < taken_.size(); ++c) {
      if (taken_[c]) continue;
      double least = INFINITY, sum = 0;
      for (const Open& open : ties_) {
        const double progress = open.progress(open.fit.gain(open.rows[c]));
        least = std::min(least, progress);
        sum += std::min(progress, 1.0);
      }
      const double value = std::min(least, 2.0) + 1e-2 * sum + 1e-4 * least;
      if (value <= best_value) continue;
      best_value = value;
      place = c;
    }
    return place;
  }
  /// The tie that loses most without this point.
  [[nodiscard]] const Tie& reason(std::size_t candidate) {
    put(candidate, false);
    const Open* most = &ties_.front();
    double largest = -1;
    for (const Open& open : ties_) {
      const double share = open.fit.gain(open.rows[candidate]) / open.needed;
      if (share <= largest) continue;
      largest = share;
      most = &open;
    }
    put(candidate, true);
    return *most->tie;
  }

 private:
  std::vector<Open> ties_;
  std::vector<bool> taken_;
};

/// The first points of a new set-up only tell what the new set-up is: begin with points spread over
/// all candidates, exchange each for the best, and add until every tie is decided.
std::vector<std::size_t> choose(Search& search, std::size_t most) {
  most = std::min(most, search.candidates());
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; chosen.size() < std::min(kFirst, most); ++k) {
    std::size_t c = (k * 377 + 11) % search.candidates();  // 377: no common stride with the lattice
    while (search.taken(c)) c = (c + 1) % search.candidates();
    chosen.push_back(c);
    search.put(c, true);
  }
  const auto exchange = [&] {
    for (std::size_t& place : chosen) {
      search.put(place, false);
      place = search.best();
      search.put(place, true);
    }
  };
  exchange();
  while (search.worst() < 1 && chosen.size() < most) {
    for (std::size_t k = 0; k < kMore && chosen.size() < most; ++k) {
      chosen.push_back(search.best());
      search.put(chosen.back(), true);
    }
  }
  exchange();
  return chosen;
}

/// States worth offering: as the readings were left, and what the ties can be told apart by.
std::vector<NextState> states(const Conditions& last, const std::vector<Tie>& ties) {
  bool temperature = false, time = false, length = false;
  for (const Tie& tie : ties) {
    length = length || tie.by_length;
    for (const int e : tie.effects) {
      for (const Need need : effect_catalogue()[static_cast<std::size_t>(e)].needs) {
        temperature = temperature || (need == Need::temperature && last.temp_degc);
        time = time || (need == Need::time && last.time_s);
      }
    }
  }
  std::vector<NextState> all = {{}};
  const auto add = [&](std::optional<double> temp_degc, std::optional<double> wait_h) {
    all.push_back({temp_degc, wait_h});
  };
  const auto warmer = [&] { return std::round(*last.temp_degc + kWarmerK); };
  if (temperature) add(warmer(), {});
  if (time) add({}, kWaitH);
  if (temperature && time) add(warmer(), kWaitH);
  const std::size_t usual = all.size();
  for (const double approach_mm : kOtherApproachesMm) {
    for (std::size_t i = 0; length && i < usual; ++i) {
      all.push_back(all[i]);
      all.back().approach_mm = approach_mm;
    }
  }
  return all;
}

Conditions conditions_in(const NextState& state, const Conditions& last, bool new_epoch) {
  Conditions there = last;
  if (new_epoch) ++there.epoch;
  if (last.time_s) {
    there.time_s = *last.time_s + kSetUpS + state.wait_h.value_or(0) * kSecondsPerHour;
  }
  if (state.temp_degc) there.temp_degc = state.temp_degc;
  return there;
}

/// A way through the points that goes to the nearest next: a person can follow it, and it is short.
void put_in_order(std::vector<NextPoint>& points) {
  const auto key = [](const NextPoint& p) {
    return std::tuple(p.target.phi_rad, p.target.x_mm, p.target.y_mm, p.approach);
  };
  std::sort(points.begin(), points.end(),
            [&](const NextPoint& a, const NextPoint& b) { return key(a) < key(b); });
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const Pose& at = points[k].target;
    const auto nearer = [&at](const NextPoint& a, const NextPoint& b) {
      const auto far = [&at](const NextPoint& p) {
        constexpr double kTurnLeverMm = 100;
        return std::hypot(p.target.x_mm - at.x_mm, p.target.y_mm - at.y_mm,
                          kTurnLeverMm * (p.target.phi_rad - at.phi_rad));
      };
      return far(a) < far(b);
    };
    const auto rest = points.begin() + static_cast<std::ptrdiff_t>(k) + 1;
    std::iter_swap(rest, std::min_element(rest, points.end(), nearer));
  }
}

/// The plan in one state of machine and clock, with how far it decides the worst tie.
struct Proposal {
  NextPoints plan;
  double worst = 0;
};

struct Known {
  const GeometryFit& base;
  const Design& design;
  const std::vector<Seen>& readings;
  const std::vector<Tie>& ties;
  const Conditions& last;
  const std::vector<Place>& bounds;
  const NextOptions& options;
};

Open open_tie(const Known& k, const Tie& tie, const std::vector<Seen>& candidates) {
  std::vector<Rows> rows;
  for (const Seen& s : k.readings) rows.push_back(rows_of(k.design, tie, s));
  for (const Seen& s : candidates) rows.push_back(rows_of(k.design, tie, s));
  reduce(rows);
  Open open;
  open.tie = &tie;
  const auto old = rows.begin() + static_cast<std::ptrdiff_t>(k.readings.size());
  const Eigen::Index n = rows.front().columns.cols();
  open.fit.N = kWeakPrior * Eigen::MatrixXd::Identity(n, n);
  open.fit.moment = Eigen::VectorXd::Zero(n);
  for (auto r = rows.begin(); r != old; ++r) open.fit.add(*r);
  open.fit.solve();
  open.before = open.fit.leftover();
  open.needed = energy_needed(tie.lead);
  for (const Rows& r : rows) open.most += r.signal.squaredNorm();
  open.rows.assign(old, rows.end());
  return open;
}

Proposal propose(const Known& k, const NextState& state) {
  const bool by_direction =
      std::any_of(k.ties.begin(), k.ties.end(), [](const Tie& t) { return t.by_direction; });
  const std::vector<Visit> all =
      candidates(k.base.model.nominal, k.bounds, conditions_in(state, k.last, k.options.new_epoch),
                 state.approach_mm, by_direction);
  std::vector<Seen> seen;
  for (const Visit& c : all) seen.push_back(k.design.seen(c.conditions));
  Proposal proposal;
  NextPoints& plan = proposal.plan;
  plan.state = state;
  std::vector<Open> hopeful;
  plan.energy_before = plan.energy_after = INFINITY;
  for (const Tie& tie : k.ties) {
    Open open = open_tie(k, tie, seen);
    plan.energy_before = std::min(plan.energy_before, open.before);
    if (!all.empty() && open.most - open.before >= kHopeless) {
      if (hopeful.size() < kMostTies) hopeful.push_back(std::move(open));
    } else {
      plan.undecided.push_back({tie.why, tie.instead});
      plan.energy_after = std::min(plan.energy_after, open.before);
    }
  }
  if (hopeful.empty()) return proposal;
  Search search(std::move(hopeful));
  for (const std::size_t c : choose(search, static_cast<std::size_t>(k.options.most))) {
    plan.points.push_back({all[c].target, all[c].approach, search.reason(c).why});
  }
  for (const Open& open : search.ties()) {
    plan.energy_after = std::min(plan.energy_after, open.fit.leftover());
    if (open.fit.leftover() - open.before < kHopeless) {
      plan.undecided.push_back({open.tie->why, open.tie->instead});
    }
  }
  proposal.worst = search.worst();
  put_in_order(plan.points);
  return proposal;
}

/// Fewer ties left undecided, then the worst decided further, counts as better.
bool better(const Proposal& a, const Proposal& b) {
  if (a.plan.undecided.size() != b.plan.undecided.size()) {
    return a.plan.undecided.size() < b.plan.undecided.size();
  }
  return std::min(a.worst, 1.0) > std::min(b.worst, 1.0) + 0.1;  // a change of state is a burden
}

}  // namespace

Tie::Term effect_term(int effect, int parameter, double value) {
  const Effect& e = effect_catalogue()[static_cast<std::size_t>(effect)];
  return {[&e, parameter](const Reading&, const Moment& m) {
            return recorded(e, m) ? e.basis(m, parameter) : Deviation{};
          },
          value};
}

double energy_needed(double lead) {
  constexpr double z = 3;
  const double root = z + std::sqrt(z * z + std::max(0.0, kEvidence20To1 - lead));
  return root * root;
}

NextPoints plan_next_points(const GeometryFit& base, const std::vector<Reading>& readings,
                            const PoseSigma& sigma, const std::vector<Tie>& ties,
                            const NextOptions& options) {
  if (ties.empty() || readings.empty()) return {};
  std::vector<Reading> epochs = readings;
  if (options.new_epoch) {
    epochs.emplace_back();
    epochs.back().conditions.epoch = readings.back().conditions.epoch + 1;
  }
  const Design design(base, sigma, base_parameters(base.model.nominal, epochs));
  std::vector<Seen> seen;
  for (const Reading& r : readings) seen.push_back(design.seen(r.conditions));
  const std::vector<Place> bounds = options.within.empty() ? bounds_of(readings) : options.within;
  const Known known{base, design, seen, ties, readings.back().conditions, bounds, options};
  std::optional<Proposal> best;
  for (const NextState& state : states(known.last, ties)) {
    if (best && best->plan.undecided.empty() && best->worst >= 1) break;
    Proposal proposal = propose(known, state);
    if (!best || better(proposal, *best)) best = std::move(proposal);
  }
  if (best->plan.undecided.size() == ties.size()) best->plan.points.clear();
  return best->plan;
}

}  // namespace trammel
