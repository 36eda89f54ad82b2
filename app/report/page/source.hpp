#pragma once
// What the sections of a page are made from, read once.

#include <nlohmann/json.hpp>

#include "app/report/methods.hpp"
#include "app/report/page/item.hpp"
#include "app/report/report.hpp"

namespace trammel::report {

struct Source {
  store::Connection& connection;
  const store::CampaignRow& campaign;
  const Measured& measured;
  const Jobs& jobs;
  const std::vector<Group>& groups;
  const std::vector<Comparison>& comparisons;
  const std::vector<Comparison>& circles;  // one for each standing
  const Report& report;
};

// One section each, in the page's order. A figure that the campaign has no data for is absent and
// says why.
Json verdict_section(const Source& source);
Json plan_section(const Source& source);
Json map_section(const Source& source);
Json point_section(const Source& source);
Json fit_section(const Source& source);
Json circle_section(const Source& source);
Json contest_section(const Source& source);
Json story_section(const Source& source);
Json residual_section(const Source& source);
Json facts_section(const Source& source);

/// "lsq-80"; "lsq-80-SESSION" where another comparison has that name.
std::string id_of(const Source& source, const Comparison& comparison);
/// "least squares on the geometry, 80 points: in-sample, measured again"
std::string words_of(const Comparison& comparison);
/// What is judged and how "after" is known.
std::string set_words(const Comparison& comparison);

/// The comparison a reader wants first, as the verdict's sentence has it; null where there is none.
const Comparison* headline(const Source& source);

/// The largest error of any comparison, before or after, mm or deg: one colour scale for all maps.
double largest_error(const Source& source, bool position);

}  // namespace trammel::report
