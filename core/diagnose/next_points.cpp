#include "core/diagnose/next_points.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/mechanism/velocity.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kApproachMm = 5;
constexpr double kLaterS = 900;       // set-up time before the new points
constexpr double kHopeless = 6;       // leftover energy below which a tie stays a tie
constexpr double kSafeMargin = 0.15;  // of the singularity measure
constexpr double kWeakPrior = 1e-4;   // tolerances are believed this little: keeps N regular

struct Proposal {
  Pose target;
  std::array<int, 3> approach;
  Conditions conditions;
};

bool reachable(const Mechanism& mechanism, const Pose& pose, InverseResult& at) {
  at = inverse(mechanism.geometry, pose);
  if (!at.ok()) return false;
  const Limits& limits = mechanism.limits;
  if (at.l_mm.minCoeff() < limits.l_min_mm + kApproachMm ||
      at.l_mm.maxCoeff() > limits.l_max_mm - kApproachMm) {
    return false;
  }
  return singularity(mechanism.geometry, velocity_equation(mechanism.geometry, pose, at)).margin() >
         kSafeMargin;
}

std::vector<Proposal> candidates(const Mechanism& mechanism, const std::vector<Reading>& readings) {
  const Reading& last = readings.back();
  std::vector<Proposal> all;
  for (const double phi_deg : {0.0, -4.0, 4.0}) {
    for (int ix = -2; ix <= 2; ++ix) {
      for (int iy = -2; iy <= 2; ++iy) {
        const Pose pose{45.0 * ix, 45.0 * iy, rad_from_deg(phi_deg)};
        InverseResult at;
        if (!reachable(mechanism, pose, at)) continue;
        for (int bits = 0; bits < 8; ++bits) {
          Proposal c{pose, {}, last.conditions};
          c.conditions.cmd_mm = c.conditions.from_mm = at.l_mm;
          for (int rail = 0; rail < kChains; ++rail) {
            const int direction = bits >> rail & 1 ? 1 : -1;
            c.approach[static_cast<std::size_t>(rail)] = direction;
            c.conditions.from_mm[rail] -= direction * kApproachMm;
          }
          c.conditions.epoch = last.conditions.epoch + 1;
          if (last.conditions.time_s) c.conditions.time_s = *last.conditions.time_s + kLaterS;
          all.push_back(c);
        }
      }
    }
  }
  return all;
}

/// Rows of one reading: what is free to imitate, and the signal.
struct Rows {
  Eigen::Matrix3Xd columns;
  Eigen::Vector3d signal;
};

class TieRows {
 public:
  TieRows(const GeometryFit& base, const std::vector<FreeParameter>& parameters,
          const TrackerSigma& sigma, const Tie& tie)
      : base_(base),
        parameters_(parameters),
        tie_(tie),
        inverse_sigma_(1 / sigma.xy_mm, 1 / sigma.xy_mm, 1 / sigma.phi_rad) {}

  [[nodiscard]] Eigen::Index columns() const {
    return static_cast<Eigen::Index>(parameters_.size() + tie_.columns.size());
  }

  [[nodiscard]] Rows at(const Conditions& conditions) const {
    const Prediction here = moment_of(base_.model, conditions);
    Rows rows{Eigen::Matrix3Xd(3, columns()), Eigen::Vector3d::Zero()};
    const auto n = static_cast<Eigen::Index>(parameters_.size());
    rows.columns.leftCols(n) = derivative(base_.model, parameters_, conditions, here);
    for (std::size_t k = 0; k < tie_.columns.size(); ++k) {
      const Tie::Term& term = tie_.columns[k];
      const double usual =
          effect(term).parameters[static_cast<std::size_t>(term.parameter)].usual_max;
      rows.columns.col(n + static_cast<Eigen::Index>(k)) = usual * seen(here, term);
    }
    for (const Tie::Term& term : tie_.signal) rows.signal += term.value * seen(here, term);
    rows.columns = inverse_sigma_.asDiagonal() * rows.columns;
    rows.signal = rows.signal.cwiseProduct(inverse_sigma_);
    return rows;
  }

 private:
  static const Effect& effect(const Tie::Term& term) {
    return effect_catalogue()[static_cast<std::size_t>(term.effect)];
  }
  static Eigen::Vector3d seen(const Prediction& here, const Tie::Term& term) {
    if (!recorded(effect(term), here.moment)) return Eigen::Vector3d::Zero();
    return response(here, effect(term).basis(here.moment, term.parameter));
  }

  const GeometryFit& base_;
  const std::vector<FreeParameter>& parameters_;
  const Tie& tie_;
  Eigen::Vector3d inverse_sigma_;
};

/// Least squares of the signal on the columns, one reading after the other.
struct Imitation {
  Eigen::MatrixXd N;  // columns' columns
  Eigen::VectorXd moment;
  double energy = 0;  // signal' signal
  Eigen::LDLT<Eigen::MatrixXd> solver;
  Eigen::VectorXd b;

  void add(const Rows& rows, double sign = 1) {
    N += sign * rows.columns.transpose() * rows.columns;
    moment += sign * rows.columns.transpose() * rows.signal;
    energy += sign * rows.signal.squaredNorm();
  }
  void solve() {
    solver.compute(N);
    b = solver.solve(moment);
  }
  [[nodiscard]] double leftover() const { return std::max(0.0, energy - moment.dot(b)); }
  [[nodiscard]] double gain(const Rows& rows) const {
    const Eigen::Vector3d d = rows.signal - rows.columns * b;
    const Eigen::Matrix3d C =
        Eigen::Matrix3d::Identity() + rows.columns * solver.solve(rows.columns.transpose());
    return d.dot(C.ldlt().solve(d));
  }
};

Imitation imitation_of(const TieRows& rows, const std::vector<Reading>& readings) {
  Imitation fit;
  fit.N = kWeakPrior * Eigen::MatrixXd::Identity(rows.columns(), rows.columns());
  fit.moment = Eigen::VectorXd::Zero(rows.columns());
  for (const Reading& r : readings) fit.add(rows.at(r.conditions));
  fit.solve();
  return fit;
}

/// All a search for points needs: the candidates' rows for every tie, and every tie's imitation so
/// far.
struct Search {
  std::vector<Imitation> fits;
  std::vector<std::vector<Rows>> rows;  // by tie, by candidate

  void add(std::size_t candidate, double sign) {
    for (std::size_t t = 0; t < fits.size(); ++t) {
      fits[t].add(rows[t][candidate], sign);
      fits[t].solve();
    }
  }
  [[nodiscard]] double smallest() const {
    double e = INFINITY;
    for (const Imitation& fit : fits) e = std::min(e, fit.leftover());
    return e;
  }
  /// The candidate that leaves the weakest tie the most energy; the others break ties among
  /// candidates.
  [[nodiscard]] std::size_t best() const {
    std::size_t place = 0;
    double best_value = -1;
    for (std::size_t c = 0; c < rows.front().size(); ++c) {
      double least = INFINITY, sum = 0;
      for (std::size_t t = 0; t < fits.size(); ++t) {
        const double energy = fits[t].leftover() + fits[t].gain(rows[t][c]);
        least = std::min(least, energy);
        sum += std::min(energy, kDecided);
      }
      if (least + 1e-3 * sum > best_value) {
        best_value = least + 1e-3 * sum;
        place = c;
      }
    }
    return place;
  }
  [[nodiscard]] std::size_t most_helped(std::size_t candidate) const {
    std::size_t place = 0;
    double most = -1;
    for (std::size_t t = 0; t < fits.size(); ++t) {
      const double gain = fits[t].gain(rows[t][candidate]);
      if (gain > most) {
        most = gain;
        place = t;
      }
    }
    return place;
  }
};

Search make_search(const GeometryFit& base, const std::vector<Reading>& readings,
                   const TrackerSigma& sigma, const std::vector<Tie>& ties,
                   const std::vector<Proposal>& all) {
  std::vector<Reading> epochs = readings;
  epochs.emplace_back();
  epochs.back().conditions.epoch = readings.back().conditions.epoch + 1;
  const std::vector<FreeParameter> parameters = base_parameters(epochs);
  Search search;
  for (const Tie& tie : ties) {
    const TieRows rows(base, parameters, sigma, tie);
    search.fits.push_back(imitation_of(rows, readings));
    search.rows.emplace_back();
    for (const Proposal& c : all) search.rows.back().push_back(rows.at(c.conditions));
  }
  return search;
}

}  // namespace

NextPoints plan_next_points(const GeometryFit& base, const std::vector<Reading>& readings,
                            const TrackerSigma& sigma, const std::vector<Tie>& ties, int most) {
  constexpr int kPasses = 2;
  NextPoints plan;
  if (ties.empty() || readings.empty()) return plan;
  const std::vector<Proposal> all = candidates(base.model.mechanism, readings);
  if (all.empty()) return plan;
  Search search = make_search(base, readings, sigma, ties, all);
  plan.energy_before = search.smallest();

  // The first points of a new set-up only tell what the new set-up is: begin with points spread
  // over all candidates, then exchange each for the best.
  const auto wanted = static_cast<std::size_t>(most);
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < wanted; ++k) {
    chosen.push_back((k * 377 + 11) % all.size());  // 377: no common stride with the grid
    search.add(chosen.back(), 1);
  }
  for (int pass = 0; pass < kPasses; ++pass) {
    for (std::size_t& place : chosen) {
      search.add(place, -1);
      place = search.best();
      search.add(place, 1);
    }
  }
  plan.energy_after = search.smallest();
  for (const std::size_t c : chosen) {
    plan.points.push_back({all[c].target, all[c].approach, ties[search.most_helped(c)].why});
  }
  for (std::size_t t = 0; t < ties.size(); ++t) {
    if (search.fits[t].leftover() < kHopeless) plan.undecided.push_back(ties[t].why);
  }
  if (plan.undecided.size() == ties.size())
    plan.points.clear();  // more of the same decides nothing
  return plan;
}

}  // namespace trammel
