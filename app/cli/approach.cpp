#include "app/cli/approach.hpp"

#include <fmt/format.h>

#include <map>

#include "app/terminal/counted.hpp"
#include "core/error.hpp"

namespace trammel::cli {

Approach parse_approach(const std::string& text) {
  const std::map<char, int> kSigns = {{'+', 1}, {'-', -1}, {'0', 0}};
  Approach approach = {0, 0, 0};
  bool good = !text.empty() && text.size() <= kChains;
  for (std::size_t i = 0; good && i < text.size(); ++i) {
    good = kSigns.contains(text[i]);
    if (good) approach[i] = kSigns.at(text[i]);
  }
  if (!good) {
    throw UsageError(
        {.what = "no direction of approach",
         .where = {.field = "--approach"},
         .got = text,
         .expected = "one of + - 0 for each drive, as '+-0', or '+-' on a stage of two"});
  }
  return approach;
}

void require_drives(const Approach& approach, const Machine& machine) {
  const int n = machine.kind->n_chains;
  for (int i = n; i < kChains; ++i) {
    if (approach[static_cast<std::size_t>(i)] == 0) continue;
    throw UsageError({.what = fmt::format("an {} machine has {}", machine.kind->name,
                                          terminal::counted(static_cast<std::size_t>(n), "drive")),
                      .where = {.field = "--approach"},
                      .got = approach_text(approach),
                      .expected = "one of + - 0 for each"});
  }
}

std::string approach_text(const Approach& approach) {
  std::string text;
  for (const int d : approach) text += d > 0 ? '+' : d < 0 ? '-' : '0';
  return text;
}

}  // namespace trammel::cli
