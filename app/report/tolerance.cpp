#include "app/report/tolerance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/files/budget_json.hpp"
#include "app/report/assess/assessment.hpp"
#include "app/report/gather.hpp"
#include "app/report/methods.hpp"
#include "app/report/print.hpp"
#include "app/terminal/lines.hpp"
#include "app/terminal/table.hpp"
#include "core/error.hpp"
#include "core/judge/budget.hpp"
#include "core/measure/noise.hpp"

namespace trammel::report {

namespace {

/// The set of the assessment that the table is made of.
const assess::Judged& set_of(const assess::Assessment& assessment, const ErrorTable& table) {
  const auto& sets = assessment.job->sets;
  const auto at = std::ranges::find_if(sets, [&table](const assess::Judged& set) {
    return set.session == table.session && set.set == table.set && set.standing == table.standing &&
           set.points.size() == table.points.size();
  });
  if (at == sets.end()) {
    throw InputError({.what = "the job's uncertainty is not known at these points",
                      .got = fmt::format("job {}, session {}", table.job, table.session),
                      .hint = fmt::format("see trammel assess --job {}", table.job)});
  }
  return *at;
}

void judge_table(JudgedPoints& judged, store::Connection& connection,
                 const store::CampaignRow& campaign, const ErrorTable& table,
                 double U_measured_mm) {
  judged.method = table.method;
  judged.session = table.session;
  judged.standing = table.standing;
  judged.predicted = table.after_predicted;
  for (const PointError& p : table.points) {
    judged.points.push_back({p.x_mm, p.y_mm, p.after, U_measured_mm});
  }
  if (!judged.predicted) return;
  const assess::Assessment assessment =
      assess::gather(connection, campaign, "", std::to_string(table.job));
  const assess::Judged& set = set_of(assessment, table);
  judged.U_from = assessment.job->uncertainty_from + ", with the noise of a reading";
  for (std::size_t k = 0; k < judged.points.size(); ++k) {
    judged.points[k].U_mm = {};
    if (const auto& U = set.points[k].U)
      judged.points[k].U_mm = 2 * std::hypot(U->U_mm / 2, judged.u_reading_mm);
  }
}

void judge_baseline(JudgedPoints& judged, const Measured& measured, double U_measured_mm) {
  for (const Group& group : baseline_groups(measured)) {
    const std::string& name = group.walk->session.name;
    if (judged.session.find(name) == std::string::npos) {
      judged.session += (judged.session.empty() ? "" : ", ") + name;
    }
    for (const Visit* visit : group.visits) {
      const Reading& r = visit->reading;
      judged.points.push_back({r.target.x_mm, r.target.y_mm,
                               error_in(Figure::position_mm, *r.measured, r.target),
                               U_measured_mm});
    }
  }
}

}  // namespace

JudgedPoints judged_points(store::Connection& connection, const store::CampaignRow& campaign,
                           const Gathered& gathered) {
  const Measured& measured = gathered.measured;
  const NoiseLevel noise = noise_level(measured.campaign);
  const auto budget =
      budget_of(measured.campaign, budget_facts(measured.campaign), noise, std::nullopt);
  const double u_mm = noise.sigma.xy_mm, beside_mm = combined_mm(budget, false);
  const double U_measured_mm = 2 * std::hypot(u_mm, beside_mm);
  JudgedPoints judged{.u_reading_mm = u_mm, .decimals = gathered.report.decimals_mm};
  judged.U_from = beside_mm == 0 ? "twice the noise of a reading"
                                 : fmt::format(
                                       "twice the root of the squares of the noise of a "
                                       "reading, {0:.{2}f} mm, and of the budget, {1:.{2}f} mm",
                                       u_mm, beside_mm, judged.decimals);
  if (const ErrorTable* best = best_table(gathered.report)) {
    judge_table(judged, connection, campaign, *best, U_measured_mm);
  } else {
    judge_baseline(judged, measured, U_measured_mm);
  }
  return judged;
}

long ToleranceTest::n(Conformity is) const { return std::ranges::count(verdicts, is); }

ToleranceTest tolerance_test(JudgedPoints points, double tolerance_mm) {
  ToleranceTest test{.tolerance_mm = tolerance_mm, .of = std::move(points)};
  for (const JudgedPoint& p : test.of.points) {
    test.verdicts.push_back(p.U_mm ? conformity(p.error_mm, *p.U_mm, tolerance_mm)
                                   : Conformity::undecided);
  }
  test.machine = conformity_of_all(test.verdicts);
  return test;
}

std::string whose_words(const JudgedPoints& points) {
  if (points.method.empty()) return "as it is, without a correction";
  return fmt::format("under {}, {}, {}", method_words(points.method), name_of(points.standing),
                     points.predicted ? "predicted" : "measured again");
}

std::string tolerance_words(const ToleranceTest& test) {
  return fmt::format(
      "Against a tolerance of {:g} mm it {}: of {} {} pass, {} fail, {} can't be decided",
      test.tolerance_mm,
      test.machine == Conformity::undecided ? "can't be decided" : name_of(test.machine),
      points_in_words(test.verdicts.size()), test.n(Conformity::passes), test.n(Conformity::fails),
      test.n(Conformity::undecided));
}

std::string tolerance_text(const ToleranceTest& test) {
  std::string text =
      terminal::heading(fmt::format("Position error within {:g} mm?", test.tolerance_mm));
  text += terminal::wrapped(fmt::format(
      "{}. The machine is judged {}. A point passes where its error and U are within the tolerance "
      "together, fails where its error less U is beyond it (ISO 14253-1). U (k = 2): {}.",
      tolerance_words(test), whose_words(test.of), test.of.U_from));
  terminal::Table table({"x mm", "y mm", "error mm", "U mm", "verdict"});
  for (std::size_t k = 0; k < test.verdicts.size(); ++k) {
    const JudgedPoint& p = test.of.points[k];
    table.add({fmt::format("{:.3f}", p.x_mm), fmt::format("{:.3f}", p.y_mm),
               fmt::format("{:.{}f}", p.error_mm, test.of.decimals),
               p.U_mm ? fmt::format("{:.{}f}", *p.U_mm, test.of.decimals) : "-",
               name_of(test.verdicts[k])});
  }
  return text + "\n" + table.text();
}

}  // namespace trammel::report
