#include "app/job/points.hpp"

namespace trammel::job {

std::string points_text(const std::vector<store::JobPoint>& points) {
  const auto column = [&points](const auto& of) {
    std::vector<decltype(of(points.front()))> values;
    values.reserve(points.size());
    for (const store::JobPoint& p : points) values.push_back(of(p));
    return canonical_list(values);
  };
  return canonical_object(
      {{"seq", column([](const store::JobPoint& p) { return p.seq; })},
       // a number, as the views have it
       {"in_sample", column([](const store::JobPoint& p) { return p.in_sample ? 1 : 0; })},
       {"x_mm", column([](const store::JobPoint& p) { return p.after.x_mm; })},
       {"y_mm", column([](const store::JobPoint& p) { return p.after.y_mm; })},
       {"phi_rad", column([](const store::JobPoint& p) { return p.after.phi_rad; })}});
}

std::vector<store::JobPoint> points_of(store::Connection& connection, const store::Job& job) {
  const Json result = Json::parse(job.data.result_json);
  if (!result.contains("points")) return store::stored_points(connection, job.id);
  const Json& columns = result["points"];
  std::vector<store::JobPoint> points;
  for (std::size_t k = 0; k < columns.at("seq").size(); ++k) {
    const auto real = [&](const char* name) { return columns.at(name).at(k).get<double>(); };
    points.push_back({.seq = columns.at("seq").at(k).get<int>(),
                      .in_sample = columns.at("in_sample").at(k).get<int>() != 0,
                      .after = {real("x_mm"), real("y_mm"), real("phi_rad")}});
  }
  return points;
}

}  // namespace trammel::job
