#include "tests/stress/soak.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/calibrate/lsq.hpp"
#include "core/statistics/random.hpp"
#include "tests/app/session/socket_campaign.hpp"

namespace trammel::test {

namespace {

using emulate::Emulated;
using emulate::FaultKind;
using tests::SocketCampaign;

constexpr int kMostLives = 1000;

struct Kind {
  Emulated where;
  FaultKind kind;
  std::uint64_t most;  // occasions from now on, of which one is struck
};
constexpr std::array<Kind, 12> kSoakKinds = {{
    {Emulated::stage, FaultKind::lost_reply, 30},
    {Emulated::stage, FaultKind::half_reply, 30},
    {Emulated::stage, FaultKind::dropped, 30},
    {Emulated::stage, FaultKind::limit_hit, 3},
    {Emulated::stage, FaultKind::amplifier_fault, 3},
    {Emulated::stage, FaultKind::stall, 3},
    {Emulated::tracker, FaultKind::lost_reply, 15},
    {Emulated::tracker, FaultKind::half_reply, 15},
    {Emulated::tracker, FaultKind::dropped, 15},
    {Emulated::tracker, FaultKind::beam_break, 3},
    {Emulated::tracker, FaultKind::beam_lost, 12},
    {Emulated::tracker, FaultKind::unstable, 3},
}};

struct Died {};  // of what nobody catches: a life ends between two statements

/// One life of the runner, from the set-up to its end.
class Lifetime {
 public:
  Lifetime(SocketCampaign& campaign, Random& random, double share) : campaign_(campaign) {
    const auto one_in = [&random](std::uint64_t n) { return random.below(n) == 0; };
    dies_after_ = one_in(3) ? static_cast<int>(random.below(40)) : -1;
    stops_after_ = one_in(4) ? static_cast<int>(random.below(40)) : -1;
    campaign.begun = [&campaign, &random, share](int) {
      if (random.uniform() >= share) return;
      const Kind& kind = kSoakKinds[random.below(kSoakKinds.size())];
      campaign.faults(kind.where).add({kind.kind, 1 + random.below(kind.most), ""});
    };
  }

  /// How it ended; nothing when it died.
  std::optional<session::Outcome> live() {
    session::Surroundings around = campaign_.around;
    around.stored = [this](int n) {
      campaign_.witness();
      acknowledged_ = n;
      if (n == dies_after_) throw Died{};
    };
    around.stop_signals = [this] {
      return stops_after_ >= 0 && acknowledged_ >= stops_after_ ? 1 : 0;
    };
    try {
      return session::run_or_resume(campaign_.db, campaign_.request, around);
    } catch (const Died&) {
      return std::nullopt;
    }
  }
  [[nodiscard]] int acknowledged() const { return acknowledged_; }

 private:
  SocketCampaign& campaign_;
  int dies_after_ = -1, stops_after_ = -1;
  int acknowledged_ = 0;  // points of this life
};

struct Stored {
  int n_ok = 0;
  int begun = 0;  // points of which a try was begun
};
Stored stored_in(SocketCampaign& campaign) {
  Stored stored;
  std::map<int, bool> begun;
  for (const store::Attempt& a : campaign.attempts()) {
    begun[a.point_seq] = true;
    stored.n_ok += a.status == "ok" ? 1 : 0;
  }
  stored.begun = static_cast<int>(begun.size());
  return stored;
}

LsqResult identified(SocketCampaign& campaign) {
  std::vector<Reading> readings;
  for (const auto& [seq, reading] : tests::by_point(campaign.db, "c", "s")) {
    readings.push_back(reading);
    readings.back().seq = seq;
  }
  const device::Devices devices =
      device::open_devices(campaign.request.stage, campaign.request.tracker);
  return identify_linear(mechanism_of(devices.machine), readings, *devices.sigma,
                         {.shared_epochs = true});
}

/// Along the principal axes of what is identified, where the differences are independent of each
/// other:  C = D R D,  R = Q L Q',  z = L^-1/2 Q' D^-1 (a - b) / sqrt 2,  each z of variance 1.
void compare(const LsqResult& found, const LsqResult& expected, SoakCount& count) {
  constexpr double kLeast = 1e-9;  // of an axis of R: less is not identified
  const Eigen::MatrixXd& C = expected.covariance;
  const Eigen::VectorXd D = C.diagonal().cwiseSqrt();
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(D.size());
  for (Eigen::Index k = 0; k < D.size(); ++k) inverse[k] = D[k] > 0 ? 1 / D[k] : 0;
  const Eigen::MatrixXd R = inverse.asDiagonal() * C * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(R);
  const Eigen::VectorXd off =
      axes.eigenvectors().transpose() * inverse.cwiseProduct(found.values() - expected.values());
  for (Eigen::Index k = 0; k < off.size(); ++k) {
    if (axes.eigenvalues()[k] < kLeast) continue;
    ++count.parameters;
    const double z = std::abs(off[k]) / std::sqrt(2 * axes.eigenvalues()[k]);
    count.worst_sigma = std::max(count.worst_sigma, z);
  }
}

}  // namespace

Plan soak_plan(int n_points) {
  PlanRequest request{.name = "soak", .groups = {{"", paper_80()}}};
  Plan plan;
  for (request.repeats = 1; static_cast<int>(plan.points.size()) < n_points; ++request.repeats) {
    plan = build_plan(request);
  }
  plan.points.resize(static_cast<std::size_t>(n_points));
  return plan;
}

tests::SocketOptions steady() {
  tests::SocketOptions options;
  options.truth.temperature.rise_k = 0;
  options.base_nests = false;  // found anew in each life, its noise would be one for many readings
  options.step_s = 0.05;
  return options;
}

WireCount sweep_wires(FaultKind kind, std::uint64_t stride) {
  Plan plan = tests::small_plan();
  plan.points.resize(4);
  WireCount count;
  for (const Emulated where : {Emulated::stage, Emulated::tracker}) {
    for (std::uint64_t line = 1;; line += stride) {
      SocketCampaign campaign(plan);
      campaign.faults(where).add({kind, line, ""});
      session::Outcome outcome = campaign.run();
      if (campaign.struck() == 0) break;  // the campaign has no more lines
      ++count.runs;
      if (outcome.state ==
          session::State::faulted) {  // before it was homed, nothing is tried again
        ++count.resumed;
        outcome = campaign.run();
      }
      auto problems = campaign.problems();
      if (outcome.state != session::State::done) problems.push_back(outcome.detail);
      if (problems.empty()) continue;
      ++count.wrong;
      if (count.first_problem.empty()) {
        count.first_problem =
            fmt::format("{} at line {} to the {}: {}", emulate::name_of(kind), line,
                        where == Emulated::stage ? "stage" : "tracker", problems.front());
      }
    }
  }
  return count;
}

SoakCount soak_over_sockets(const SoakOptions& options) {
  const Plan plan = soak_plan(options.n_points);
  SocketCampaign calm(plan, steady());
  const session::Outcome undisturbed = calm.run();
  SoakCount count;
  const auto problem = [&count](const std::string& what) {
    if (count.first_problem.empty()) count.first_problem = what;
  };
  if (undisturbed.state != session::State::done) problem("without faults: " + undisturbed.detail);

  SocketCampaign campaign(plan, steady());
  Random random(options.seed);
  session::State state = session::State::planned;
  while (state != session::State::done && count.lives < kMostLives) {
    const int before = count.lives == 0 ? 0 : stored_in(campaign).n_ok;
    Lifetime life(campaign, random, options.share);
    const auto outcome = life.live();
    ++count.lives;
    count.deaths += outcome ? 0 : 1;
    if (outcome) state = outcome->state;
    const Stored stored = stored_in(campaign);
    if (stored.n_ok < before + life.acknowledged()) {
      ++count.lost;
      problem(fmt::format("{} acknowledged, {} there", before + life.acknowledged(), stored.n_ok));
    }
    count.early += stored.begun > stored.n_ok ? 1 : 0;
    if (outcome && state == session::State::faulted) campaign.free_rails();
  }
  if (state != session::State::done) problem("it never came to its end");
  for (const store::Attempt& a : campaign.attempts()) count.failed_tries += a.status == "failed";
  count.points = stored_in(campaign).n_ok;
  count.faults = campaign.struck();
  for (SocketCampaign* one : {&calm, &campaign}) {
    for (const std::string& what : one->problems()) {
      ++count.wrong;
      problem(what);
    }
  }
  if (state == session::State::done) compare(identified(campaign), identified(calm), count);
  return count;
}

}  // namespace trammel::test
