#include "core/calibrate/optimal_plan.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/calibrate/geometry_fit.hpp"
#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/linear/products.hpp"
#include "core/plan/grids.hpp"
#include "core/plane/hull.hpp"
#include "core/statistics/random.hpp"

namespace trammel {

namespace {

constexpr int kMaxPasses = 30;           // a bound: it ends where no exchange is worth it
constexpr int kMaxPoints = 2000;         // a plan of days; exchanging grows with their square
constexpr std::size_t kShortList = 16;   // candidates whose eigenvalues E works out
constexpr double kWorthExchange = 1e-9;  // of the criterion: less is rounding

struct Candidate {
  Pose pose;
  Approach approach = {};
};

bool needs_direction(const DesignModel& design) {
  for (const ActiveEffect& active : design.model.effects) {
    const auto& needs = active.effect->needs;
    if (std::find(needs.begin(), needs.end(), Need::direction) != needs.end()) return true;
  }
  return false;
}

std::vector<Approach> approaches(bool directed, int n_drives) {
  if (!directed) return {{0, 0, 0}};
  std::vector<Approach> all;
  for (int k = 0; k < 1 << n_drives; ++k) {
    Approach approach = {0, 0, 0};
    for (int i = 0; i < n_drives; ++i) {
      approach[static_cast<std::size_t>(i)] = (k >> i) % 2 == 1 ? 1 : -1;
    }
    all.push_back(approach);
  }
  return all;
}

std::vector<Candidate> safe_candidates(const NominalMachine& machine, const OptimalRequest& request,
                                       bool directed) {
  std::vector<Candidate> all;
  const int n = machine.machine().kind->n_chains;
  const Pose& home = machine.machine().home;
  for (const double phi_rad : request.orientations_rad) {
    if (n < 3 && phi_rad != home.phi_rad) continue;  // it does not turn
    for (Pose pose : lattice(request.half_width_mm, request.step_mm)) {
      if (!request.within.empty() && !inside(request.within, {pose.x_mm, pose.y_mm})) continue;
      if (n < 2 && pose.y_mm != home.y_mm) continue;
      pose.phi_rad = phi_rad;
      for (const Approach& approach : approaches(directed, n)) {
        const Plan one{"", request.approach_mm, {{.seq = 1, .target = pose, .approach = approach}}};
        if (check(one, machine.machine(), request.check).empty()) all.push_back({pose, approach});
      }
    }
  }
  if (all.empty()) {
    throw InputError({.what = "no candidate of the plan can be measured safely",
                      .expected = "poses within reach, limits and away from singularities",
                      .hint = "a smaller --half-width, other --within, or other --orientations"});
  }
  return all;
}

/// The design while it is being improved; H has three rows per candidate, in the directions that
/// all candidates together identify.
class Exchange {
 public:
  Exchange(Eigen::MatrixXd H, Criterion criterion, std::vector<Eigen::Index> chosen)
      : H_(std::move(H)), criterion_(criterion), chosen_(std::move(chosen)) {
    M_.setIdentity(H_.cols(), H_.cols());
    for (const Eigen::Index c : chosen_) add(c, 1);
  }

  [[nodiscard]] double value() const {
    if (criterion_ == Criterion::E) return smallest_eigenvalue(M_);
    const Cholesky factor(M_);
    return criterion_ == Criterion::D ? factor.log_determinant() : factor.inverse().trace();
  }

  /// Every point in turn; true when one was exchanged.
  bool pass() {
    bool changed = false;
    for (Eigen::Index& at : chosen_) {
      add(at, -1);
      const Eigen::VectorXd gains = criterion_ == Criterion::E ? gains_E(at) : gains_DA();
      Eigen::Index best = 0;
      gains.maxCoeff(&best);
      if (gains[best] > gains[at] + kWorthExchange * std::abs(gains[at])) {
        at = best;
        changed = true;
      }
      add(at, 1);
    }
    return changed;
  }

  [[nodiscard]] const std::vector<Eigen::Index>& chosen() const { return chosen_; }

 private:
  void add(Eigen::Index candidate, double sign) {
    add_gram(M_, H_.middleRows<3>(3 * candidate), sign);
  }

  /// D: log det(I + h P h'); A: tr((I + h P h')^-1 h P P h'), P = M^-1 (matrix determinant lemma,
  /// Woodbury).
  [[nodiscard]] Eigen::VectorXd gains_DA() const {
    const Eigen::MatrixXd HP = product(H_, Cholesky(M_).inverse());
    Eigen::VectorXd gains(H_.rows() / 3);
    for (Eigen::Index c = 0; c < gains.size(); ++c) {
      const auto hP = HP.middleRows<3>(3 * c);
      const Eigen::Matrix3d small =
          Eigen::Matrix3d::Identity() + rows_product(hP, H_.middleRows<3>(3 * c));
      if (criterion_ == Criterion::D) {
        gains[c] = std::log(determinant(small));
      } else {
        gains[c] = (inverse(small) * rows_product(hP, hP)).trace();
      }
    }
    return gains;
  }

  /// lambda_min with each candidate of the short list, and with the one that was there; the others
  /// get nothing.
  [[nodiscard]] Eigen::VectorXd gains_E(Eigen::Index was) const {
    const Eigen::VectorXd stretched = times(H_, symmetric_eigen(M_).vectors.col(0));
    std::vector<Eigen::Index> order(static_cast<std::size_t>(H_.rows() / 3));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    const auto more = [&](Eigen::Index a, Eigen::Index b) {
      const double sa = stretched.segment<3>(3 * a).squaredNorm();
      const double sb = stretched.segment<3>(3 * b).squaredNorm();
      return sa > sb || (sa == sb && a < b);
    };
    const std::size_t n = std::min(kShortList, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(n), order.end(),
                      more);
    order.resize(n);
    order.push_back(was);
    Eigen::VectorXd gains = Eigen::VectorXd::Zero(H_.rows() / 3);
    for (const Eigen::Index c : order) {
      Eigen::MatrixXd with = M_;
      add_gram(with, H_.middleRows<3>(3 * c), 1);
      gains[c] = smallest_eigenvalue(with);
    }
    return gains;
  }

  Eigen::MatrixXd H_;
  Criterion criterion_;
  std::vector<Eigen::Index> chosen_;
  Eigen::MatrixXd M_;
};

/// The chosen candidates as a plan: nearest next, the same pose and direction again is a repeat.
Plan as_plan(const OptimalRequest& request, const std::vector<Candidate>& candidates,
             std::vector<Eigen::Index> left) {
  Plan plan{request.name, request.approach_mm, {}};
  std::map<Eigen::Index, int> visits;
  Pose at;
  while (!left.empty()) {
    const auto far = [&](Eigen::Index c) {
      const Pose& p = candidates[static_cast<std::size_t>(c)].pose;
      return std::hypot(p.x_mm - at.x_mm, p.y_mm - at.y_mm);
    };
    const auto next =
        std::min_element(left.begin(), left.end(), [&](Eigen::Index a, Eigen::Index b) {
          return far(a) < far(b) || (far(a) == far(b) && a < b);
        });
    const Candidate& c = candidates[static_cast<std::size_t>(*next)];
    plan.points.push_back({.seq = static_cast<int>(plan.points.size()) + 1,
                           .target = c.pose,
                           .set = request.set,
                           .approach = c.approach,
                           .repeat = ++visits[*next]});
    at = c.pose;
    left.erase(next);
  }
  validate(plan);
  return plan;
}

void require_sensible(const OptimalRequest& request) {
  if (request.points >= 2 && request.points <= kMaxPoints && !request.orientations_rad.empty()) {
    return;
  }
  throw InputError(
      {.what = "the plan cannot be chosen",
       .where = {.field = "points"},
       .got = std::to_string(request.points) + " points, " +
              std::to_string(request.orientations_rad.size()) + " orientations",
       .expected = "2 to " + std::to_string(kMaxPoints) + " points, at least one orientation"});
}

}  // namespace

OptimalPlan optimal_plan(const NominalMachine& machine, const OptimalRequest& request) {
  require_sensible(request);
  const DesignModel design = design_model(machine, request.sigma, request.effects);
  const auto candidates = safe_candidates(machine, request, needs_direction(design));
  std::vector<Conditions> conditions;
  for (const Candidate& c : candidates) {
    conditions.push_back(conditions_at(machine, c.pose, c.approach, request.approach_mm));
  }
  const Eigen::MatrixXd J = design_jacobian(design, conditions);
  Random random = Random::stream(request.seed, "optimal plan");
  std::vector<Eigen::Index> start;
  for (int k = 0; k < request.points; ++k) {
    start.push_back(static_cast<Eigen::Index>(random.below(candidates.size())));
  }
  Exchange exchange(product(J, identifiable(J).directions), request.criterion, start);
  OptimalPlan result;
  result.candidates = static_cast<int>(candidates.size());
  result.at_start = exchange.value();
  while (result.passes < kMaxPasses) {
    ++result.passes;
    if (!exchange.pass()) break;
  }
  result.at_end = exchange.value();
  result.plan = as_plan(request, candidates, exchange.chosen());
  result.jacobian = design_jacobian(design, expected_conditions(result.plan, machine));
  return result;
}

}  // namespace trammel
