#pragma once
// What a stored campaign shows in a metrologist's terms, session by session and under one job.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/judge/before_after.hpp"
#include "core/judge/budget.hpp"
#include "core/judge/iso230.hpp"
#include "core/judge/iso9283.hpp"
#include "core/judge/seen.hpp"
#include "core/statistics/interval.hpp"
#include "core/statistics/summary.hpp"
#include "store/campaign.hpp"

namespace trammel::assess {

struct Session {
  std::string name, plan;
  std::optional<store::Id> compensation_job;
  std::string compensation;  // empty: baseline
  Summary position_mm, attitude_rad;
  Iso9283 poses;
  std::vector<Iso230> rails;
  std::string drive = "rail";  // what a drive of the machine is called
  std::string verdict;         // against the floor; empty when the noise is not known
};

struct Point {
  int seq = 0;
  Pose target;
  double before_mm = 0, after_mm = 0;
  std::optional<Expanded> U = {};  // k = 2, of a coordinate; within the range that was fitted
  std::string why_no_U = {};       // outside it
};

/// Points of one session and set before and after the job's correction.
struct Judged {
  std::string session, set;
  Standing standing = Standing::unseen;
  bool predicted = false;        // after is predicted, not measured again
  bool cross_validated = false;  // each point under a correction fitted without its block
  Summary before_mm, after_mm;
  std::optional<double> improvement_pct;
  std::optional<Interval> improvement_95_pct;
  std::string verdict;
  std::vector<Point> points;
  /// Held-out, of the points with U: coordinates of place within U (k = 2) and the reading's noise;
  /// 95 is expected.
  std::optional<double> covered_pct;
  std::size_t n_covered = 0;  // points with U that it counts

  [[nodiscard]] bool in_sample() const { return standing == Standing::fitted; }
};

struct JobAssessment {
  store::Id id = 0;
  std::string stage;
  std::string uncertainty_from;
  std::vector<Judged> sets;
  std::vector<BudgetRow> budget;  // behind U; none where the noise is not known
  std::vector<std::string> warnings;
};

struct Assessment {
  std::string campaign;
  bool simulated = false;
  std::string noise;  // where sigma comes from, or why there is none
  std::optional<double> floor_mean_mm;
  std::vector<Session> sessions;
  std::optional<JobAssessment> job;
};

/// Assesses the sessions of a campaign (one with `session`), and a job's correction with `job`: on
/// the points it fitted and on those it did not, measured again where a session did so, else
/// predicted. Where no stored point is held out, by cross-validation over spatial blocks.
/// Throws NotFoundError (session, job), InputError (nothing measured; a job of another campaign).
/// Proof: assess_test.cpp.
Assessment gather(store::Connection& connection, const store::CampaignRow& campaign,
                  const std::string& session, const std::string& job);

nlohmann::ordered_json to_json(const Assessment& assessment);
std::string to_text(const Assessment& assessment);

}  // namespace trammel::assess
