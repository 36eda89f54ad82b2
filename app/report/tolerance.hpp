#pragma once
// Whether the machine meets a tolerance on its position error (`report --tolerance`).

#include <optional>
#include <string>
#include <vector>

#include "core/judge/seen.hpp"
#include "core/judge/tolerance.hpp"
#include "store/campaign.hpp"

namespace trammel::report {

struct Gathered;

struct JudgedPoint {
  double x_mm = 0, y_mm = 0;
  double error_mm = 0;
  std::optional<double> U_mm = {};  // k = 2; none beyond the range that was fitted
};

/// The points that stand for the machine.
struct JudgedPoints {
  std::string method = {};  // empty: as it is, without a correction
  std::string session = {};
  Standing standing = Standing::unseen;
  bool predicted = false;
  std::string U_from = {};
  double u_reading_mm = 0;  // of a coordinate, one standard deviation
  int decimals = 4;         // of error and U, for a person
  std::vector<JudgedPoint> points = {};
};

/// The points of best_table under its correction; without a calibration all baseline points as they
/// are. U (k = 2) of an error that was measured:
///   U = 2 sqrt(u_reading^2 + u_budget^2),   u_budget: all rows but the model's (budget_of)
/// the model is not asked: what it left was measured. Of one that is predicted: what `assess` makes
/// of the job, budget and all, with the noise of a reading; none beyond its range. Throws
/// InputError where the noise is not known. Proof: tolerance_report_test.cpp.
JudgedPoints judged_points(store::Connection& connection, const store::CampaignRow& campaign,
                           const Gathered& gathered);

struct ToleranceTest {
  double tolerance_mm = 0;
  JudgedPoints of = {};
  std::vector<Conformity> verdicts = {};  // of each point
  Conformity machine = Conformity::undecided;

  [[nodiscard]] long n(Conformity is) const;
};

/// Proof: tolerance_report_test.cpp.
ToleranceTest tolerance_test(JudgedPoints points, double tolerance_mm);

/// "the geometry with the named effects, unseen, measured again"
std::string whose_words(const JudgedPoints& points);

/// "Against a tolerance of 0.05 mm it passes: of 48 points 48 pass, 0 fail, 0 can't be decided"
std::string tolerance_words(const ToleranceTest& test);

std::string tolerance_text(const ToleranceTest& test);

}  // namespace trammel::report
