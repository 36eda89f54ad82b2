#include "app/files/points_look.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/error.hpp"
#include "core/judge/iso9283.hpp"

namespace trammel {

namespace {

/// How places are told apart when nobody says: a name that comes back is one.
PlaceBy recognised(const std::vector<PointRow>& rows) {
  std::set<std::string> names, groups;
  bool twice = false, grouped = true;
  for (const PointRow& row : rows) {
    twice = (!row.name.empty() && !names.insert(row.group + '\0' + row.name).second) || twice;
    grouped = grouped && !row.group.empty();
  }
  if (twice) return PlaceBy::name;
  return grouped ? PlaceBy::group : PlaceBy::file;
}

std::string place_of(const PointRow& row, PlaceBy by) {
  if (by == PlaceBy::file) return "all";
  if (by == PlaceBy::group) return row.group.empty() ? "(no group)" : row.group;
  const std::string name = row.name.empty() ? "(no name)" : row.name;
  return row.group.empty() ? name : row.group + "/" + name;
}

/// The rows less those that were shot again, which hold no place in a round.
std::vector<const PointRow*> rows_of_rounds(const PointsFile& file, int cycle) {
  std::vector<const PointRow*> rows;
  for (const PointRow& row : file.rows) {
    if (row.miss != Miss::deleted) rows.push_back(&row);
  }
  const auto n = static_cast<std::size_t>(cycle);
  for (std::size_t k = n; k < rows.size(); ++k) {
    const std::string& before = rows[k - n]->name;
    if (rows[k]->name == before || file.format == "sa") continue;  // sa counts its points
    throw InputError({.what = "this row is out of turn",
                      .where = {.file = file.name, .line = rows[k]->line, .field = "name"},
                      .got = rows[k]->name,
                      .expected = before,
                      .hint = "is a row missing above?"});
  }
  if (rows.size() % n == 0) return rows;
  throw InputError({.what = "the rows do not go round the nests",
                    .where = {.file = file.name},
                    .got = std::to_string(rows.size()) + " rows",
                    .expected = "a multiple of " + std::to_string(cycle)});
}

PlaceLook looked_at(const std::string& place, const std::vector<const PointRow*>& rows,
                    const OutlierRule& rule) {
  PlaceLook look;
  look.place = place;
  std::vector<Eigen::Vector3d> points;
  std::vector<int> lines;
  for (const PointRow* row : rows) {
    if (row->miss) {
      look.misses.push_back({row->line, *row->miss});
    } else {
      points.push_back(row->at_mm);
      lines.push_back(row->line);
    }
  }
  const Screened screened = screen(points, rule);
  look.limit_mm = screened.limit_mm;
  look.median_mm = screened.median_mm;
  std::vector<Eigen::Vector3d> kept;
  double square = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double distance_mm = (points[k] - screened.median_mm).norm();
    if (std::binary_search(screened.outliers.begin(), screened.outliers.end(), k)) {
      look.outliers.push_back({lines[k], distance_mm});
    } else {
      kept.push_back(points[k]);
      square += distance_mm * distance_mm;
    }
  }
  look.n = static_cast<int>(kept.size());
  if (look.n > 0) look.rms_mm = std::sqrt(square / look.n);
  if (look.n >= kLeastVisits) look.RP_l_mm = point_repeatability_mm(kept);
  return look;
}

}  // namespace

PointsLook look_at(const PointsFile& file, std::optional<PlaceBy> by, int cycle,
                   const OutlierRule& rule) {
  PointsLook look{.by = by.value_or(recognised(file.rows)), .cycle = cycle, .places = {}};
  std::vector<std::string> order;
  std::map<std::string, std::vector<const PointRow*>> rows;
  const auto add = [&](const std::string& place, const PointRow& row) {
    auto& there = rows[place];
    if (there.empty()) order.push_back(place);
    there.push_back(&row);
  };
  if (cycle > 0) {
    std::size_t k = 0;
    for (const PointRow* row : rows_of_rounds(file, cycle)) {
      add(std::to_string(k++ % static_cast<std::size_t>(cycle) + 1), *row);
    }
  }
  for (const PointRow& row : file.rows) {
    if (cycle == 0) add(place_of(row, look.by), row);
    look.n_without_u95 += row.u95_mm && *row.u95_mm == 0 ? 1 : 0;
  }
  for (const std::string& place : order) look.places.push_back(looked_at(place, rows[place], rule));
  return look;
}

}  // namespace trammel
