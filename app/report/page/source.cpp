#include "app/report/page/source.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/judge/deviation.hpp"
#include "core/units.hpp"

namespace trammel::report {

namespace {

double mean_after_mm(const Comparison& c) {
  double sum = 0;
  for (const Pair& p : c.paired.pairs) sum += position_error_mm(p.after, p.before->reading.target);
  return sum / static_cast<double>(c.paired.pairs.size());
}

}  // namespace

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

std::string set_words(const Comparison& c) {
  return fmt::format("{} points, {}, after {}", c.paired.pairs.size(),
                     c.in_sample ? "in-sample (the fit saw them)" : "held-out (no fit saw them)",
                     c.paired.predicted ? "predicted from the readings before" : "measured again");
}

std::string words_of(const Comparison& c) {
  return fmt::format("{}, {} points, {}", method_words(method_of(*c.job)), c.paired.pairs.size(),
                     c.in_sample ? "in-sample" : "held-out");
}

const Comparison* headline(const Source& source) {
  const Comparison* best = nullptr;
  for (const Comparison& c : source.comparisons) {
    const bool better = best == nullptr || (best->in_sample && !c.in_sample) ||
                        (best->in_sample == c.in_sample && mean_after_mm(c) < mean_after_mm(*best));
    if (better) best = &c;
  }
  return best;
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
