#include "app/report/page/source.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/report/print.hpp"
#include "core/judge/deviation.hpp"
#include "core/units.hpp"

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

std::string set_words(const Comparison& c) {
  return fmt::format("{} points, {}, after {}", c.paired.pairs.size(), standing_words(c.standing),
                     c.paired.predicted ? "predicted from the readings before" : "measured again");
}

std::string words_of(const Comparison& c) {
  return fmt::format("{}, {} points, {}", method_words(method_of(*c.job)), c.paired.pairs.size(),
                     name_of(c.standing));
}

const Comparison* headline(const Source& source) {
  const ErrorTable* best = best_table(source.report);
  if (best == nullptr) return nullptr;
  // Each comparison has a table of position and one of attitude, in this order (gather.cpp).
  return &source.comparisons[static_cast<std::size_t>(best - source.report.tables.data()) / 2];
}

double largest_error(const Source& source, bool position) {
  double largest = 0;
  const auto look = [&largest, position](const Pose& pose, const Pose& target) {
    largest = std::max(largest, position ? position_error_mm(pose, target)
                                         : deg_from_rad(attitude_error_rad(pose, target)));
  };
  for (const Comparison& c : source.comparisons) {
    for (const Pair& p : c.paired.pairs) {
      look(*p.before->reading.measured, p.before->reading.target);
      look(p.after, p.before->reading.target);
    }
  }
  return largest;
}

}  // namespace trammel::report
