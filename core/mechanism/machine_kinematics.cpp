#include "core/mechanism/machine_kinematics.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear/decompositions.hpp"

namespace trammel {

namespace {

Eigen::Matrix3d scaled_by_size(const Machine& machine, const Closures& at) {
  if (machine.kind->has_point_platform()) return at.F_X;
  double r_mm = 0;
  const auto parameters = machine.kind->chain->parameters;
  const auto r = std::ranges::find(parameters, "r", &ChainParameter::symbol) - parameters.begin();
  for (const ChainValues& p : machine.chains) r_mm += p[static_cast<std::size_t>(r)] / kChains;
  Eigen::Matrix3d scaled = at.F_X;
  scaled.col(2) /= r_mm;
  return scaled;
}

}  // namespace

Closures closures(const Machine& machine, const Displacements& q_mm, const Pose& X) {
  const MachineKind& kind = *machine.kind;
  Closures at;
  const auto& parameters = parameters_of(kind);
  at.F_p = ParameterColumns::Zero(3, static_cast<Eigen::Index>(parameters.size()));
  std::array<ClosureRow, kChains> rows;
  for (int i = 0; i < kind.n_chains; ++i) {
    ClosureRow& row = rows[static_cast<std::size_t>(i)];
    row = kind.chain->closure(machine.chains[static_cast<std::size_t>(i)], q_mm[i], X);
    at.F[i] = row.f;
    at.F_q[i] = row.f_q;
    at.F_X.row(i).head(kind.n_chains) = row.f_X.head(kind.n_chains);
  }
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const MachineParameter& p = parameters[k];
    at.F_p(p.chain, static_cast<Eigen::Index>(k)) =
        rows[static_cast<std::size_t>(p.chain)].f_p[p.place];
  }
  return at;
}

Eigen::Matrix3d velocity_jacobian(const Closures& at) {
  return -inverse(at.F_X) * at.F_q.asDiagonal();
}

ParameterColumns error_jacobian(const Closures& at) { return -inverse(at.F_X) * at.F_p; }

Singularity singularity(const Machine& machine, const Closures& at) {
  const auto n = machine.kind->n_chains;
  const double best = machine.kind->has_point_platform() ? 1 : std::sqrt(3.0);
  return {at.F_q.head(n).cwiseAbs().minCoeff(),
          smallest_singular_value(scaled_by_size(machine, at)) / best};
}

int assembly(const Closures& at) { return determinant(at.F_X) < 0 ? -1 : 1; }

DrivesAt drives_at(const Machine& machine, const Pose& X, const Eigen::Vector3d& X_dot,
                   const Eigen::Vector3d& X_ddot) {
  DrivesAt at;
  const Eigen::Vector3d pose = X.vector();
  MovingPose on_its_way;
  for (int c = 0; c < 3; ++c) {
    on_its_way[static_cast<std::size_t>(c)] = moving(pose[c], X_dot[c], X_ddot[c]);
  }
  std::array<Eigen::Vector3d, 3> angle = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                                          Eigen::Vector3d::Zero()};
  bool has_angle = true;
  for (int i = 0; i < machine.kind->n_chains; ++i) {
    const auto chain =
        machine.kind->chain->drive(machine.chains[static_cast<std::size_t>(i)], on_its_way);
    if (!chain) {
      at.missed = i;
      return at;
    }
    at.q_mm[i] = value_of(chain->q);
    at.velocity_mm_s[i] = rate_of(chain->q);
    at.acceleration_mm_s2[i] = acceleration_of(chain->q);
    has_angle = has_angle && chain->angle;
    if (!has_angle) continue;
    angle[0][i] = value_of(*chain->angle);
    angle[1][i] = rate_of(*chain->angle);
    angle[2][i] = acceleration_of(*chain->angle);
  }
  if (has_angle) at.angle = angle;
  return at;
}

namespace {

/// +1 or -1, 0 within kSingularMargin; nothing out of reach.
std::optional<int> side_of(const Machine& machine, const Pose& pose) {
  const DrivesAt at = drives_at(machine, pose);
  if (!at.reached()) return {};
  const Closures here = closures(machine, at.q_mm, pose);
  return singularity(machine, here).margin() < kSingularMargin ? 0 : assembly(here);
}

}  // namespace

Reach reach(const Machine& machine, const Pose& pose) {
  Reach result;
  if (!pose.vector().allFinite()) return result;
  result.at = drives_at(machine, pose);
  if (!result.at.reached()) {
    result.status = Reach::Status::unreachable;
    result.chain = result.at.missed;
    return result;
  }
  result.stroke_left_mm = INFINITY;
  for (int i = 0; i < machine.kind->n_chains; ++i) {
    const Limits& limits = machine.drives[static_cast<std::size_t>(i)].limits;
    const double q = result.at.q_mm[i];
    const double left = std::min(q - limits.l_min_mm, limits.l_max_mm - q);
    if (left >= result.stroke_left_mm) continue;
    result.stroke_left_mm = left;
    result.chain = i;
  }
  const Closures here = closures(machine, result.at.q_mm, pose);
  result.singularity = singularity(machine, here);
  if (result.singularity.margin() < kSingularMargin) {
    result.status = Reach::Status::singular;
    return result;
  }
  const auto home = side_of(machine, machine.home);
  result.assembly = assembly(here) * home.value_or(0);
  result.status = result.assembly < 0         ? Reach::Status::other_assembly
                  : result.stroke_left_mm < 0 ? Reach::Status::limit
                                              : Reach::Status::ok;
  return result;
}

const char* name_of(Reach::Status status) {
  constexpr std::array<const char*, 6> kNames = {"ok",    "not finite", "unreachable",
                                                 "limit", "singular",   "other assembly"};
  return kNames[static_cast<std::size_t>(status)];
}

const char* name_of(MachinePose::Status status) {
  constexpr std::array<const char*, 3> kNames = {"ok", "unreachable", "singular"};
  return kNames[static_cast<std::size_t>(status)];
}

const char* assembly_name(int assembly) {
  return assembly > 0 ? "home" : assembly < 0 ? "other" : "none";
}

namespace {

constexpr int kNewtonSteps = 50;             // of one call; quadratic, so 4 to 6 from a good start
constexpr int kNewtonHalvings = 12;          // a step of which no 1/4000 helps leads nowhere
constexpr double kNewtonFoundMm = 1e-12;     // of the drives, and mm: as forward.hpp stops
constexpr double kNewtonRoundingMm = 1e-11;  // what a step that no longer improves may leave
constexpr double kSameDriveMm = 1e-8;  // the closed form gives the drives back: the working mode

/// Newton's steps within one assembly.
class InAssembly {
 public:
  InAssembly(const Machine& machine, int side) : machine_(machine), side_(side) {}

  /// From `X` to a pose at `q_mm`; nothing where the steps end at a singular pose or elsewhere.
  std::optional<Pose> find(const Displacements& q_mm, Pose X) {
    const double tolerance = kNewtonFoundMm * std::max(1.0, q_mm.cwiseAbs().maxCoeff());
    Closures at = closures(machine_, q_mm, X);
    double previous = INFINITY;
    for (int step = 0; step < kNewtonSteps; ++step, ++iterations) {
      const double gap = at.F.cwiseAbs().maxCoeff(&farthest);
      if (!(gap < INFINITY)) return {};
      if (gap <= tolerance || (gap <= kNewtonRoundingMm && gap >= previous))
        return in_mode(q_mm, X);
      previous = gap;
      Eigen::Vector3d by = -(inverse(at.F_X) * at.F);
      Closures next;
      Pose there;
      bool better = false;
      for (int halving = 0; halving < kNewtonHalvings && !better; ++halving, by *= 0.5) {
        there = Pose::from(X.vector() + by);
        next = closures(machine_, q_mm, there);
        better = assembly(next) == side_ &&
                 (next.F.cwiseAbs().maxCoeff() < gap || gap <= kNewtonRoundingMm);
      }
      if (!better) return {};
      X = there;
      at = next;
    }
    return {};
  }

  /// As the drives go straight from `X`'s to `q_mm`, in shorter pieces where a whole one fails.
  std::optional<Pose> follow(const Displacements& q_mm, Pose X) {
    const Displacements from = drives_at(machine_, X).q_mm;
    constexpr double kShortest = 1.0 / 64;  // piece of the way
    double done = 0, piece = 1;
    while (done < 1) {
      const double to = std::min(1.0, done + piece);
      const auto there = find(from + (q_mm - from) * to, X);
      if (!there) {
        piece *= 0.5;
        if (piece < kShortest) return {};
        continue;
      }
      X = *there;
      done = to;
      piece *= 2;
    }
    return X;
  }

  int iterations = 0;
  int farthest = 0;  // the chain with the largest gap where the last call ended

 private:
  [[nodiscard]] std::optional<Pose> in_mode(const Displacements& q_mm, const Pose& X) const {
    const DrivesAt back = drives_at(machine_, X);
    if (!back.reached() || (back.q_mm - q_mm).cwiseAbs().maxCoeff() > kSameDriveMm) return {};
    const Closures at = closures(machine_, q_mm, X);
    if (assembly(at) != side_ || singularity(machine_, at).margin() < kSingularMargin) return {};
    return X;
  }

  const Machine& machine_;
  int side_;
};

Pose wrapped(const Pose& pose) {
  return {pose.x_mm, pose.y_mm, std::remainder(pose.phi_rad, 2 * kPi)};
}

/// Poses strewn about home, from near to far: where to look when the way from the start is closed.
std::vector<Pose> strewn(const Machine& machine) {
  double span_mm = 0;
  for (const Drive& d : machine.drives) {
    span_mm = std::max(span_mm, d.limits.l_max_mm - d.limits.l_min_mm);
  }
  std::vector<Pose> poses;
  for (const double turn_deg :
       {0., 20., -20., 40., -40., 60., -60., 90., -90., 135., -135., 180.}) {
    for (const double share : {0., 0.2, 0.4}) {
      for (int k = 0; k < (share == 0 ? 1 : 6); ++k) {
        const double at = k * kPi / 3;
        poses.push_back({machine.home.x_mm + share * span_mm * std::cos(at),
                         machine.home.y_mm + share * span_mm * std::sin(at),
                         machine.home.phi_rad + rad_from_deg(turn_deg)});
      }
    }
  }
  return poses;
}

}  // namespace

MachinePose forward(const Machine& machine, const Displacements& q_mm, const Pose& start) {
  MachinePose result;
  const auto side = side_of(machine, start);
  if (side == 0) result.status = MachinePose::Status::singular;
  if (!q_mm.allFinite() || side.value_or(0) == 0) return result;
  InAssembly search(machine, *side);
  std::optional<Pose> found = search.follow(q_mm, start);
  result.chain = search.farthest;
  if (!found && !machine.kind->has_point_platform()) {
    for (const Pose& pose : strewn(machine)) {
      if (side_of(machine, pose) != side) continue;
      found = search.find(q_mm, pose);
      if (found) break;
    }
  }
  result.iterations = search.iterations;
  if (!found) return result;
  result.status = MachinePose::Status::ok;
  result.pose = wrapped(*found);
  return result;
}

}  // namespace trammel
