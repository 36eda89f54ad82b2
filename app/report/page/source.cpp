#include "app/report/page/source.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/report/print.hpp"

namespace trammel::report {

std::string id_of(const Source& source, const Comparison& comparison) {
  const auto plain = [](const Comparison& c) {
    return fmt::format("{}-{}", method_of(*c.job), c.paired.pairs.size());
  };
  for (const Comparison& other : source.comparisons) {
    if (&other == &comparison) break;
    if (plain(other) == plain(comparison)) {
      return plain(comparison) + "-" + comparison.group->walk->session.name;
    }
  }
  return plain(comparison);
}

namespace {

const char* standing_words(Standing standing) {
  switch (standing) {
    case Standing::fitted:
      return "in-sample (the fit saw them)";
    case Standing::unseen:
      return "held-out (no fit saw them)";
    case Standing::unknown_epoch:
      return "of an epoch that the fit knows nothing of: they do not judge it";
  }
  return "";
}

}  // namespace

std::string judged_words(const Comparison& c) {
  return fmt::format("{}, {}", points_in_words(c.paired.pairs.size()), standing_words(c.standing));
}

std::string after_words(bool predicted) {
  return predicted ? "after predicted from the readings before" : "after measured again";
}

std::string set_words(const Comparison& c) {
  return judged_words(c) + ", " + after_words(c.paired.predicted);
}

std::string of_the_paper(const Source& source, const char* figure) {
  return source.report.published ? fmt::format(" (the paper's {})", figure) : "";
}

Json table_beside_paper(const Source& source, const FigureHead& head,
                        std::vector<std::string> columns, Json rows) {
  if (!source.report.published) {
    columns.pop_back();
    for (Json& row : rows) row.erase(row.size() - 1);
  }
  return table(head, columns, std::move(rows));
}

std::string words_of(const Comparison& c) {
  return fmt::format("{}, {}, {}", method_words(method_of(*c.job)),
                     points_in_words(c.paired.pairs.size()), name_of(c.standing));
}

const Comparison* headline(const Source& source) {
  const ErrorTable* best = best_table(source.report);
  if (best == nullptr) return nullptr;
  // Each comparison has a table for each figure, in this order (gather.cpp).
  return &source.comparisons[static_cast<std::size_t>(best - source.report.tables.data()) /
                             figures_of(source.measured.campaign.machine).size()];
}

const char* word_of(Figure figure) {
  return figure == Figure::position_mm ? "position" : "attitude";
}

const char* unit_of(Figure figure) { return figure == Figure::position_mm ? "mm" : "deg"; }

int decimals(const Source& source, Figure figure) {
  return figure == Figure::position_mm ? source.report.decimals_mm : source.report.decimals_deg;
}

std::optional<Interval> mean_interval(const std::vector<double>& values) {
  const std::vector<double> nothing(values.size(), 0.0);
  return paired_difference(values, nothing);
}

std::string change_words(const Comparison& c, const Errors& errors) {
  if (c.standing == Standing::unknown_epoch || !errors.improvement_pct) return "-";
  const auto interval = improvement_interval_pct(errors.before, errors.after);
  return fmt::format(
      "{:+.1f} %{}", -*errors.improvement_pct,
      interval ? fmt::format("\n({:+.1f} to {:+.1f})", -interval->high, -interval->low) : "");
}

double largest_error(const Source& source, Figure figure) {
  double largest = 0;
  for (const Comparison& c : source.comparisons) {
    for (const Pair& p : c.paired.pairs) {
      const Reading& before = p.before->reading;
      largest = std::max({largest, error_in(figure, *before.measured, before.target),
                          error_in(figure, p.after, before.target)});
    }
  }
  return largest;
}

}  // namespace trammel::report
