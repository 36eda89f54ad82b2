#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "app/files/numbers.hpp"
#include "app/report/budget.hpp"
#include "app/report/methods.hpp"
#include "app/report/print.hpp"
#include "app/report/simulation.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/lines.hpp"
#include "app/terminal/text.hpp"
#include "core/statistics/interval.hpp"

namespace trammel::report {

namespace {

using terminal::printable;

std::string percent(const std::optional<double>& value) {
  return value ? fmt::format("{:+.1f} %", -*value) : "";
}

/// How a table of errors is set.
struct Columns {
  int decimals = 4;
  bool narrow = false;  // mean and maximum alone

  [[nodiscard]] int width() const { return std::max(7, decimals + 2); }  // of one number
  [[nodiscard]] int side() const { return (narrow ? 2 : 4) * (width() + 1) - 1; }
  /// mean, max, min, p95, or those that are there.
  [[nodiscard]] std::string numbers(const std::vector<double>& values) const {
    std::string text;
    for (std::size_t k = 0; k < values.size() && (k < 2 || !narrow); ++k) {
      text += fmt::format("{}{:{}.{}f}", k == 0 ? "" : " ", values[k], width(), decimals);
    }
    return text;
  }
};

std::string error_columns(const Summary& s, const Columns& columns) {
  return columns.numbers({s.mean, s.max, s.min, s.p95});
}

std::string row(const std::string& label, const std::string& set, const std::string& n,
                const std::string& before, const std::string& after, const std::string& better,
                const Columns& columns) {
  std::string line = fmt::format("{0:<15} {1:<12} {2:>4}  {3:<{6}}  {4:<{6}} {5:>9}", label, set, n,
                                 before, after, better, columns.side());
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

std::string paper_row(const PublishedTable& paper, const Columns& columns) {
  return row("  paper, " + paper.table, paper.in_sample ? "in-sample" : "held-out", "",
             columns.numbers(paper.before), columns.numbers(paper.after),
             percent(100 * (1 - paper.after[0] / paper.before[0])), columns);
}

std::string figure_tables(const Report& report, const std::string& figure, bool narrow) {
  std::string text;
  const bool position = figure == "position";
  const Columns columns{position ? report.decimals_mm : report.decimals_deg, narrow};
  const int w = columns.width();
  const std::string numbers = fmt::format("{:>{}} {:>{}}", "mean", w, "max", w) +
                              (narrow ? "" : fmt::format(" {:>{}} {:>{}}", "min", w, "p95", w));
  for (const ErrorTable& table : report.tables) {
    if (table.figure != figure) continue;
    if (text.empty()) {
      text = terminal::heading(
          fmt::format("{} error [{}]", position ? "Position" : "Attitude", table.unit));
      text += row("", "", "", "before", "after", "", columns);
      text += row("method", "judged", "n", numbers, numbers, "change", columns);
    }
    text += row(table.method + (table.after_predicted ? " *" : ""), name_of(table.standing),
                std::to_string(table.before.n), error_columns(table.before, columns),
                error_columns(table.after, columns), percent(table.improvement_pct), columns);
    if (table.paper) text += paper_row(*table.paper, columns);
  }
  const auto& floor = position ? report.floor_mean_mm : report.floor_mean_deg;
  if (!text.empty() && floor) {
    text += row("perfect reading", "", "", "", columns.numbers({*floor}), "", columns);
  }
  return text;
}

std::string remarks_text(const Report& report) {
  std::string text;
  for (const std::string& remark : report.remarks)
    text += "\n" + terminal::wrapped("Note: " + remark);
  return text;
}

std::string notes(const Report& report) {
  bool predicted = false;
  for (const ErrorTable& table : report.tables) predicted = predicted || table.after_predicted;
  bool new_epoch = false;
  for (const ErrorTable& table : report.tables) {
    new_epoch = new_epoch || table.standing == Standing::unknown_epoch;
  }
  std::string text =
      "\nin-sample: the points that were fitted judge the fit. held-out: points no fit has "
      "seen.\n" +
      std::string(new_epoch ? "new epoch: homed or framed anew since the fit, which these points "
                              "cannot judge.\n"
                            : "") +
      terminal::wrapped(
          "perfect reading: its mean length, what a perfect robot reads on average; " +
          report.noise + ".");
  if (predicted) {
    text +=
        "*: \"after\" is predicted from the readings before, not measured again: the robot keeps "
        "its\n"
        "   error, only the command changes.\n";
  }
  text += remarks_text(report);
  return text;
}

/// What is asked of the model, and whether it holds.
std::string demand_text(const Report& report) {
  std::string text;
  for (const ErrorTable& table : report.tables) {
    if (!table.demand) continue;
    const Demand& d = *table.demand;
    if (text.empty()) {
      text = fmt::format(
          "demand on the model: at least {:.0f} % better, at most {:.1f} x the mean length of a "
          "perfect reading ({:.{}f} mm)\n",
          d.improvement_pct, d.floor_ratio, d.floor_ratio * *report.floor_mean_mm,
          report.decimals_mm);
    }
    text += fmt::format(
        "  {}, {}, {}: {}, {:.2f} x a perfect reading: {}{}\n", points_in_words(table.before.n),
        name_of(table.standing), table.after_predicted ? "predicted" : "measured again",
        percent(table.improvement_pct), table.after.mean / *report.floor_mean_mm,
        d.reached ? "reached" : "not reached",
        d.within_reach() ? ""
                         : fmt::format(" (by the second alone: from this baseline a "
                                       "perfect robot shows {})",
                                       percent(d.perfect_pct)));
  }
  return text.empty() ? text : "\n" + text;
}

std::string contest_text(const Contest& c, int decimals) {
  const bool clear = std::abs(c.mean_difference_mm) > c.half_width_mm;
  const std::string& winner = c.mean_difference_mm > 0 ? c.b : c.a;
  std::string text = terminal::heading(fmt::format("{} against {}, on one baseline", c.a, c.b));
  text += fmt::format(
      "{} leaves the smaller error at {} of the same {}; mean difference {} - {} = "
      "{:+.{}f} mm,\n95 % interval +-{:.{}f} mm: {}.\n",
      c.b, c.b_better, points_in_words(static_cast<std::size_t>(c.n)), c.a, c.b,
      c.mean_difference_mm, decimals, c.half_width_mm, decimals,
      clear ? winner + " is better" : "no difference that these points can show");
  return text;
}

std::string deviation_columns(const CircleDeviation& d, int decimals) {
  std::string text;
  for (const double value_mm : {d.centre_x_mm, d.centre_y_mm, d.radius_mm}) {
    text +=
        fmt::format("{}{:+8.{}f}", text.empty() ? "" : " ", rounded(value_mm, decimals), decimals);
  }
  return text;
}

std::string circles_text(const CircleTable& circles,
                         const std::optional<CircleDeviation>& printed) {
  const int decimals = circles.errors.front().decimals;
  std::string text =
      terminal::heading(fmt::format("Circles [mm], after: {}{}", method_words(circles.method),
                                    circles.after_predicted ? ", predicted" : ", measured again"));
  text += fmt::format("{:<27} {:>3}  {:<26}    {}\n", "", "", "before", "after");
  const std::string names = fmt::format("{:>8} {:>8} {:>8}", "centre x", "centre y", "radius");
  text += fmt::format("{:<27} {:>3}  {}    {}\n", "deviation of", "n", names, names);
  for (const CircleRow& c : circles.rows) {
    text += fmt::format(
        "{:<27} {:>3}  {}    {}\n",
        fmt::format("{} ({:g}, {:g}) R {:g}", printable(c.name), c.x_mm, c.y_mm, c.radius_mm), c.n,
        deviation_columns(c.before, decimals), deviation_columns(c.after, decimals));
  }
  text += fmt::format("{:<27} {:>3}  {}    {}\n", "mean of absolute values", "",
                      deviation_columns(mean_deviation(circles, &CircleRow::before), decimals),
                      deviation_columns(mean_deviation(circles, &CircleRow::after), decimals));
  if (printed) {
    text += fmt::format("{:<27} {:>3}  {:<26}    {}\n", "  paper, XI", "", "",
                        deviation_columns(*printed, decimals));
  }
  for (const ErrorTable& e : circles.errors) {
    text += fmt::format("position error of {}, {}: mean {:.{}f} -> {:.{}f} mm{}\n",
                        points_in_words(e.before.n), name_of(e.standing), e.before.mean, e.decimals,
                        e.after.mean, e.decimals,
                        e.improvement_pct ? ", " + percent(e.improvement_pct) : "");
  }
  return text;
}

std::string parameter_line(const ParameterRow& p) {
  const std::string name = p.epoch > 1 ? fmt::format("{} (epoch {})", p.name, p.epoch) : p.name;
  const std::string value =
      p.identified
          ? fmt::format("{:>9.4f} {:<4} +- {:<8.4f}", p.value, p.unit, 2 * p.standard_uncertainty)
          : fmt::format("{:>9} {:<4}", p.dropped ? "dropped" : "-", p.unit);
  std::string line = fmt::format("  {:<26} {:<27} {}", name, value,
                                 p.paper ? fmt::format("{:>9.4f}", *p.paper) : "");
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

/// "readings know only l_1 - R_1 = 0.0307 +- 3.0960 mm (k = 2)" without the number: the table above
/// has it.
std::string without_amount(const std::string& sentence) {
  return sentence.ends_with("(k = 2)")
             ? sentence.substr(0, sentence.rfind(" = ", sentence.rfind("+-")))
             : sentence;
}

std::string identification_text(const Identification& found, bool published) {
  std::string text = terminal::heading("Identified error sources");
  text += fmt::format("rank {} of {} columns\n", found.rank, found.columns);
  text += fmt::format("  {:<26} {:<27} {:>9}\n", "", "change from nominal",
                      published ? "the paper" : "");
  for (const auto* rows : {&found.parameters, &found.combinations}) {
    for (const ParameterRow& p : *rows) text += parameter_line(p);
  }
  text += terminal::wrapped(
      std::string("-: not identified by itself, so no number is given") +
      (published ? "; the paper's there are one of many solutions that fit as well" : "") +
      ". +-: U (k = 2)" +
      (found.explained
           ? std::string(".")
           : fmt::format(
                 ", widened: residuals are {:.1f} times the noise, so the values have taken "
                 "up what constants cannot explain.",
                 found.sigma_ratio)));
  for (const std::string& sentence : found.words) {
    if (!sentence.starts_with("identified of these: ")) {
      text += terminal::wrapped("- " + without_amount(sentence), "  ");
    }
  }
  return text;
}

std::string joint_numbers(const std::array<std::optional<double>, 3>& values) {
  std::string text;
  for (const auto& value : values) text += value ? fmt::format(" {:.4f}", *value) : " -";
  return text;
}

std::string spread_words(const NetworkFit& fit) {
  if (fit.largest_sigma_mm == 0) return "as given";
  const bool at_end = fit.sigma_mm == fit.least_sigma_mm || fit.sigma_mm == fit.largest_sigma_mm;
  return fmt::format("leave-one-out, {:g} to {:g} mm{}", fit.least_sigma_mm, fit.largest_sigma_mm,
                     at_end ? ": the end of the grid" : "");
}

std::string network_text(const NetworkFit& fit, const std::optional<Published>& published) {
  std::string text = terminal::heading("Network fit, in-sample");
  text += fmt::format("{} neurons on {}, common spread {:.1f} mm ({})\n", fit.neurons,
                      terminal::counted(fit.n, "point"), fit.sigma_mm, spread_words(fit));
  text += fmt::format("MAE {:.4f} mm, MSE {:.6f} mm^2\n", fit.mae_mm, fit.mse_mm2);
  text += "R^2 = 1 - SSE/SST per joint:" + joint_numbers(fit.r2) + "\n";
  text += "squared correlation per joint:" + joint_numbers(fit.r2_pearson);
  if (!published || !published->network_mae_mm) return text + "\n";
  text += fmt::format("\nthe paper: MAE {:.4f} mm, its \"R^2\" (squared correlation):",
                      *published->network_mae_mm);
  for (const double r2 : published->network_r2_pearson) text += fmt::format(" {:.4f}", r2);
  return text + "\n";
}

std::string origin_text(const Report& report) {
  std::string text = terminal::heading("Where it comes from");
  std::size_t width = 0;
  for (const SessionRow& s : report.sessions) width = std::max(width, printable(s.name).size());
  for (const SessionRow& s : report.sessions) {
    text += fmt::format("session {:<{}} {:>13}  {:<16} {}{}\n", printable(s.name), width,
                        terminal::counted(s.n_readings, "reading"), printable(s.plan),
                        s.compensation.empty() ? "baseline" : "after " + s.compensation,
                        s.n_done < s.n_points ? fmt::format(", {} of {}", s.n_done,
                                                            terminal::counted(s.n_points, "point"))
                                              : "");
  }
  for (const JobRow& j : report.jobs) {
    text += fmt::format("job {:>3} {:<24} {}\n", j.id, j.stage, j.key.substr(0, 16));
  }
  for (const std::string& line : report.exclusions) text += "excluded: " + printable(line) + "\n";
  for (const auto& [key, value] : report.facts) {
    text += printable(key) + ": " + printable(value) + "\n";
  }
  text += "SHA-256 over all readings: " + report.chain_head + "\n";
  if (report.taken_over) {
    text += fmt::format("SHA-256 in the database of version {} they were taken over from: {}\n",
                        report.taken_over->from_version, report.taken_over->head);
  }
  return text;
}

}  // namespace

CircleDeviation mean_deviation(const CircleTable& circles, CircleDeviation CircleRow::*side) {
  CircleDeviation sum;
  const double n = static_cast<double>(circles.rows.size());
  for (const CircleRow& row : circles.rows) {
    sum.centre_x_mm += std::abs((row.*side).centre_x_mm) / n;
    sum.centre_y_mm += std::abs((row.*side).centre_y_mm) / n;
    sum.radius_mm += std::abs((row.*side).radius_mm) / n;
  }
  return sum;
}

std::optional<CircleDeviation> published_circles(const Report& report) {
  if (!report.published || report.published->circles_after_mm.empty()) return std::nullopt;
  const std::vector<double>& v = report.published->circles_after_mm;
  return CircleDeviation{v[0], v[1], v[2]};
}

const ErrorTable& most_unseen(const CircleTable& circles) {
  const auto unseen = std::ranges::find(circles.errors, Standing::unseen, &ErrorTable::standing);
  return unseen != circles.errors.end() ? *unseen : circles.errors.front();
}

namespace {

/// Less where the method comes first, by a rule that does not look at what is left of the errors:
/// the contest's pick, a model whose diagnosis is `explained`, least squares, then the others from
/// the most physical to the least.
std::ptrdiff_t rank_of(const Report& report, const ErrorTable& table) {
  const std::string& method = table.method;
  constexpr std::array<std::string_view, 7> kOrder = {"lsq", "geometry", "hybrid", "gp",
                                                      "rbf", "idw",      kModel};
  // where the diagnosis is not in this database, a model that was driven by is trusted
  const bool explained =
      report.story.empty() ? !table.after_predicted : report.story.back().verdict == "explained";
  if (method == "contest" || method == report.picked) return -2;
  if (method == kModel && explained) return -1;
  return std::ranges::find(kOrder, method) - kOrder.begin();
}

/// More where a reader should look first.
auto worth(const Report& report, const ErrorTable& table) {
  return std::tuple(table.standing == Standing::unseen, table.standing == Standing::fitted,
                    !table.after_predicted, -rank_of(report, table), table.before.n);
}

/// A model to which the diagnosis has added nothing has no named effects.
std::string named(const Report& report, const std::string& method) {
  if (method != kModel || report.story.empty() || !report.story.back().effects.empty()) {
    return method_words(method);
  }
  return "the complete geometry";
}

std::string words_for(const Report& report, const ErrorTable& best) {
  if (best.method == "contest" && !report.picked.empty()) {
    return report.picked + ", the contest's pick,";
  }
  return named(report, best.method);
}

std::string doubt(const Report& report, const ErrorTable& best) {
  if (best.method != kModel || report.story.empty()) return "";
  const StoryRound& last = report.story.back();
  if (last.verdict == "explained" && last.rivals.empty()) return "";
  return last.verdict == "explained" ? " Other sets of effects explain the readings about as well."
                                     : fmt::format(" The diagnosis itself ends {}.", last.verdict);
}

}  // namespace

const ErrorTable* best_table(const Report& report) {
  const ErrorTable* best = nullptr;
  for (const ErrorTable& table : report.tables) {
    if (table.figure != "position") continue;
    if (best == nullptr || worth(report, *best) < worth(report, table)) best = &table;
  }
  return best;
}

std::string verdict(const Report& report) {
  const ErrorTable* best = best_table(report);
  if (best == nullptr) {
    return fmt::format("{}, {}.", terminal::counted(report.n_readings, "reading"),
                       report.jobs.empty() ? "no calibration yet"
                                           : "and none that judges a calibration: a map is not "
                                             "judged by what it was fitted to");
  }
  if (best->standing == Standing::unknown_epoch) {
    return fmt::format(
        "{}, and none that judges {}: {} measured in an epoch that it knows nothing of.",
        terminal::counted(report.n_readings, "reading"), named(report, best->method),
        points_in_words(best->before.n) + (best->before.n == 1 ? " was" : " were"));
  }
  if (best->before.mean == 0) {
    return fmt::format(
        "{}, and {} of them are exactly their targets before any correction: were "
        "nominals "
        "exported? They judge nothing.",
        terminal::counted(report.n_readings, "reading"), best->before.n);
  }
  std::vector<double> before, after;
  for (const PointError& p : best->points) {
    before.push_back(p.before);
    after.push_back(p.after);
  }
  const auto interval = improvement_interval_pct(
      before, after,
      relative_u(report.budget, best->before.mean, best->after.mean, best->after_predicted));
  return fmt::format(
      "On {} {} {} {} brings the mean position error from {:.{}f} to {:.{}f} mm ({}{}{}){}.{}",
      best->before.n, best->in_sample() ? "fitted" : "unseen",
      best->before.n == 1 ? "point" : "points", words_for(report, *best), best->before.mean,
      best->decimals, best->after.mean, best->decimals,
      best->improvement_pct ? percent(best->improvement_pct) + ", " : "",
      interval
          ? fmt::format("95 % interval {:+.1f} to {:+.1f} %, ", -interval->high, -interval->low)
          : "",
      best->after_predicted ? "predicted" : "measured again",
      report.floor_mean_mm ? fmt::format("; a perfect robot would read {:.{}f} mm",
                                         *report.floor_mean_mm, report.decimals_mm)
                           : "",
      doubt(report, *best));
}

std::string to_text(const Report& report, const Page& page) {
  std::string text = "Campaign " + printable(report.campaign) +
                     fmt::format(": {}{}, {}", report.simulated ? "SIMULATED" : "real",
                                 report.imported ? ", imported" : "",
                                 terminal::counted(report.n_readings, "reading"));
  if (report.n_excluded > 0) text += fmt::format(" ({} more excluded)", report.n_excluded);
  text += "\n" + report.mechanism + "\n\n" + terminal::wrapped(verdict(report));
  if (report.tolerance) {
    text += terminal::wrapped(tolerance_words(*report.tolerance) + ".");
  }
  text += pictures(report, page.glyphs);
  text += figure_tables(report, "position", page.narrow) +
          figure_tables(report, "attitude", page.narrow);
  text += report.tables.empty() ? remarks_text(report) : notes(report) + demand_text(report);
  if (report.tolerance) text += tolerance_text(*report.tolerance);
  if (combined_mm(report.budget) > 0) {
    text += terminal::heading("What stands behind the uncertainty of " +
                              named(report, best_table(report)->method)) +
            budget_text(report.budget);
  }
  if (report.contest) text += contest_text(*report.contest, report.decimals_mm);
  if (report.circles) text += circles_text(*report.circles, published_circles(report));
  if (report.identification)
    text += identification_text(*report.identification, report.published.has_value());
  text += simulation_text(report.simulation);
  if (report.network) text += network_text(*report.network, report.published);
  text += story_text(report.story, report.decimals_mm);
  return text + origin_text(report);
}

}  // namespace trammel::report
