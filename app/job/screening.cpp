#include "app/job/screening.hpp"

#include <fmt/format.h>

namespace trammel::job {

Json findings_json(const std::vector<Suspicion>& found) {
  Json all = Json::array();
  for (const Suspicion& s : found) {
    const MistakeRule& rule = rule_of(s.kind);
    all.push_back({{"kind", rule.name},
                   {"gravity", to_string(rule.gravity)},
                   {"what", s.what},
                   {"why", s.why},
                   {"seqs", s.seqs.empty() ? Json("all") : Json(s.seqs)},
                   {"advice", rule.advice}});
  }
  return all;
}

std::string findings_text(const std::vector<Suspicion>& found) {
  std::string text;
  for (const Suspicion& s : found) {
    text += fmt::format("{:<8}{}\n", to_string(rule_of(s.kind).gravity), in_words(s));
  }
  return text;
}

}  // namespace trammel::job
