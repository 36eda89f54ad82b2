// Errors over the plane: heat, arrows, surfaces. Before and after on one scale, after on its own
// too.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "app/report/page/source.hpp"
#include "core/judge/deviation.hpp"
#include "core/mechanism/displacements.hpp"
#include "core/plane/hull.hpp"
#include "core/plane/thin_plate.hpp"
#include "core/units.hpp"

namespace trammel::report {

namespace {

constexpr int kSteps = 26;       // a map's cells along its longer side
constexpr double kArrow = 0.09;  // the longest arrow, of the map's width

/// Rows: points. Columns: error before (x_mm, y_mm, phi_deg), error after.
struct Field {
  std::vector<Place> places;
  Eigen::MatrixXd errors;  // shape (points, 6)
};

Field field_of(const Comparison& c) {
  const auto& pairs = c.paired.pairs;
  Field field{.places = {}, .errors = Eigen::MatrixXd(static_cast<Eigen::Index>(pairs.size()), 6)};
  for (Eigen::Index i = 0; i < field.errors.rows(); ++i) {
    const Pair& pair = pairs[static_cast<std::size_t>(i)];
    const Pose& target = pair.before->reading.target;
    Eigen::Vector3d before = pose_difference(*pair.before->reading.measured, target);
    Eigen::Vector3d after = pose_difference(pair.after, target);
    before[2] = deg_from_rad(before[2]);
    after[2] = deg_from_rad(after[2]);
    field.errors.row(i) << before.transpose(), after.transpose();
    field.places.push_back({target.x_mm, target.y_mm});
  }
  return field;
}

double size_of(const Eigen::VectorXd& errors, Figure figure, int first) {
  return figure == Figure::position_mm ? std::hypot(errors[first], errors[first + 1])
                                       : std::abs(errors[first + 2]);
}

/// At the points: before (first = 0) or after (3).
double largest_at(const Field& field, Figure figure, int first) {
  double largest = 0;
  for (Eigen::Index i = 0; i < field.errors.rows(); ++i) {
    largest = std::max(largest, size_of(field.errors.row(i).transpose(), figure, first));
  }
  return largest;
}

/// The field between its points, inside their hull. x runs fastest.
Json grid_json(const Field& field, const ThinPlate& surface, Figure figure) {
  double low_x = INFINITY, high_x = -INFINITY, low_y = INFINITY, high_y = -INFINITY;
  for (const Place& p : field.places) {
    low_x = std::min(low_x, p.x_mm), high_x = std::max(high_x, p.x_mm);
    low_y = std::min(low_y, p.y_mm), high_y = std::max(high_y, p.y_mm);
  }
  const double step = std::max(high_x - low_x, high_y - low_y) / kSteps;
  const int columns = 1 + static_cast<int>(std::lround((high_x - low_x) / step));
  const int rows = 1 + static_cast<int>(std::lround((high_y - low_y) / step));
  const std::vector<Place> hull = convex_hull(field.places);
  Json before = Json::array(), after = Json::array();
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Place at{low_x + i * step, low_y + j * step};
      if (!inside(hull, at, step / 2)) {
        before.push_back(nullptr);
        after.push_back(nullptr);
        continue;
      }
      const Eigen::VectorXd errors = value_at(surface, at);
      before.push_back(drawn(size_of(errors, figure, 0)));
      after.push_back(drawn(size_of(errors, figure, 3)));
    }
  }
  return {{"x_mm", drawn(low_x)}, {"y_mm", drawn(low_y)}, {"step_mm", step}, {"columns", columns},
          {"rows", rows},         {"before", before},     {"after", after}};
}

Json points_json(const Field& field) {
  Json points = Json::array();
  for (std::size_t i = 0; i < field.places.size(); ++i) {
    Json row = {drawn(field.places[i].x_mm), drawn(field.places[i].y_mm)};
    for (int k = 0; k < 6; ++k) row.push_back(drawn(field.errors(static_cast<Eigen::Index>(i), k)));
    points.push_back(std::move(row));
  }
  return points;
}

std::string paper_number(const Source& source, const Comparison& c, Figure figure) {
  static const std::map<std::string, const char*> figures = {
      {"lsq-80-position", "Fig. 9"},  {"lsq-80-attitude", "Fig. 10"},
      {"idw-48-position", "Fig. 13"}, {"idw-48-attitude", "Fig. 14"},
      {"rbf-48-position", "Fig. 18"}, {"rbf-48-attitude", "Fig. 19"}};
  const auto at = figures.find(
      fmt::format("{}-{}-{}", method_of(*c.job), c.paired.pairs.size(), word_of(figure)));
  return at == figures.end() ? "" : of_the_paper(source, at->second);
}

/// What both kinds of picture say of their colours.
const char* small_unit(Figure figure) { return figure == Figure::position_mm ? "um" : "mdeg"; }

/// `what` of a picture is seen between its points too.
std::string between(const char* what) {
  return fmt::format("Between the points {} interpolated, by a surface of least bending", what);
}

/// Of targets on one line: errors along it. Of a single axis they have a sign and a direction of
/// travel.
Json line_figure(const Source& source, const Comparison& c, const Field& field,
                 const FigureHead& head) {
  const Machine& machine = source.measured.campaign.machine;
  const bool axis = machine.kind->n_chains == 1;
  const Place from = field.places.front();
  Place to = from;  // the farthest from the first
  const auto far = [&from](const Place& p) {
    return std::hypot(p.x_mm - from.x_mm, p.y_mm - from.y_mm);
  };
  for (const Place& p : field.places) {
    if (far(p) > far(to)) to = p;
  }
  const double ux = axis || far(to) == 0 ? 1 : (to.x_mm - from.x_mm) / far(to);
  const double uy = axis || far(to) == 0 ? 0 : (to.y_mm - from.y_mm) / far(to);
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < field.errors.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::VectorXd errors = field.errors.row(i).transpose();
    const Conditions& came = c.paired.pairs[k].before->reading.conditions;
    rows.push_back({drawn(ux * field.places[k].x_mm + uy * field.places[k].y_mm),
                    axis ? directions_of(came.cmd_mm - came.from_mm)[0] : 0,
                    drawn(axis ? errors[0] : size_of(errors, Figure::position_mm, 0)),
                    drawn(axis ? errors[3] : size_of(errors, Figure::position_mm, 3))});
  }
  return report::figure(
      {head.id, head.title,
       fmt::format("{}. Each side has its own scale.{} Lines join the means.", head.caption,
                   axis ? " Full triangles: the target was approached in the direction of "
                          "positive travel; open circles: against it."
                        : "")},
      "along",
      {{"unit", small_unit(Figure::position_mm)},
       {"where", axis ? "x [mm]" : "along the line of the targets [mm]"},
       {"what", axis ? "measured - target" : "position error"},
       {"rows", std::move(rows)}});
}

}  // namespace

Json surface_figure(const Source& source, const Comparison& c, Figure figure) {
  const bool position = figure == Figure::position_mm;
  const std::string id = fmt::format("surface-{}-{}", id_of(source, c), word_of(figure));
  const std::string title = fmt::format("{} error: {}{}", position ? "Position" : "Attitude",
                                        words_of(c), paper_number(source, c, figure));
  const Field field = field_of(c);
  const auto surface = thin_plate(field.places, field.errors);
  if (!surface) return nullptr;  // the points lie on one line, which map_figure draws
  return report::figure({id, title,
                         fmt::format("{}. Before and after on one scale [{}]; last: after on its "
                                     "own [{}]. {}.",
                                     set_words(c), unit_of(figure), small_unit(figure),
                                     between("colour and height are"))},
                        "surfaces",
                        {{"unit", unit_of(figure)},
                         {"small_unit", small_unit(figure)},
                         {"max", drawn(largest_error(source, figure))},
                         {"max_after", drawn(largest_at(field, figure, 3))},
                         {"grid", grid_json(field, *surface, figure)}});
}

Json map_figure(const Source& source, const Comparison& c, const std::string& id,
                const std::string& title) {
  const Figure position = Figure::position_mm;
  const Field field = field_of(c);
  const auto surface = thin_plate(field.places, field.errors);
  if (!surface) return line_figure(source, c, field, {id, title, set_words(c)});
  Json grid = grid_json(field, *surface, position);
  const double arrow_mm = kArrow * grid["step_mm"].get<double>() * kSteps;
  const double after = largest_at(field, position, 3);
  const double factor = magnification(std::max(largest_at(field, position, 0), after), arrow_mm);
  const double own_factor = magnification(after, arrow_mm);
  return report::figure(
      {id, title,
       fmt::format(
           "{}. Arrows: from the target, {:g} times as long as the error, on the last map {:g} "
           "times. Colour: its length; the first two in mm, one scale for all maps of "
           "this page; the last on its own scale in um. {}.",
           set_words(c), factor, own_factor, between("colour is"))},
      "maps",
      {{"unit", unit_of(position)},
       {"small_unit", small_unit(position)},
       {"max", drawn(largest_error(source, position))},
       {"max_after", drawn(after)},
       {"grid", std::move(grid)},
       {"points", points_json(field)},
       {"magnification", factor},
       {"magnification_after", own_factor}});
}

}  // namespace trammel::report
