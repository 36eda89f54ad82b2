#pragma once
// What the sections of a page are made from, read once.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/report/methods.hpp"
#include "app/report/page/item.hpp"
#include "app/report/report.hpp"
#include "core/statistics/interval.hpp"

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
// says why, once in the page: a section without any is null.
Json verdict_section(const Source& source);
Json plan_section(const Source& source);
Json method_section(const Source& source);
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
/// " (the paper's Fig. 9)" of a campaign that carries the paper's figures; else "".
std::string of_the_paper(const Source& source, const char* figure);
/// `table`, whose last column is the paper's: without it where the campaign carries no such
/// figures.
Json table_beside_paper(const Source& source, const FigureHead& head,
                        std::vector<std::string> columns, Json rows);
/// "48 points, held-out (no fit saw them)"
std::string judged_words(const Comparison& comparison);
/// "after measured again"
std::string after_words(bool predicted);
/// Both.
std::string set_words(const Comparison& comparison);

/// The comparison a reader wants first, as the verdict's sentence has it; null where there is none.
const Comparison* headline(const Source& source);

// What sections share.
/// Maps of place (with `id` and `title`), and surfaces of place and attitude. Of points on one line
/// the map is a line, and the surface null.
Json map_figure(const Source& source, const Comparison& c, const std::string& id,
                const std::string& title);
Json surface_figure(const Source& source, const Comparison& c, Figure figure);
Json by_point_figure(const Source& source, const Comparison& c, Figure figure);
Json histogram_figure(const Source& source, const Comparison& c, Figure figure);
/// Simulated against measured; null where the method believes no robot.
Json simulated_figure(const Source& source, const Comparison& c);
/// The effects that the last diagnosis named, one a row, with what makes each doubtful.
Json named_table(const Source& source);

/// "position", "attitude"
const char* word_of(Figure figure);
/// "mm", "deg"
const char* unit_of(Figure figure);
/// Of errors, as the whole report has them (terminal/decimals.hpp).
int decimals(const Source& source, Figure figure);

/// "-95.2 %", and below it "(-96.0 to -94.3)": the change of the mean with its 95 % interval, "-"
/// where the points do not judge the method.
std::string change_words(const Comparison& c, const Errors& errors);
/// 95 % interval of the mean, Student's t over the points; none for fewer than five.
std::optional<Interval> mean_interval(const std::vector<double>& values);

/// The largest error of any comparison, before or after, mm or deg: one colour scale for all maps.
double largest_error(const Source& source, Figure figure);

}  // namespace trammel::report
