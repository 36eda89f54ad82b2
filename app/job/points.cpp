#include "app/job/points.hpp"

namespace trammel::job {

Json points_json(const std::vector<store::JobPoint>& points) {
  Json::array_t seq, in_sample, x_mm, y_mm, phi_rad;
  for (Json::array_t* column : {&seq, &in_sample, &x_mm, &y_mm, &phi_rad}) {
    column->reserve(points.size());
  }
  for (const store::JobPoint& p : points) {
    seq.emplace_back(p.seq);
    in_sample.emplace_back(p.in_sample ? 1 : 0);  // as the views have it
    x_mm.emplace_back(p.after.x_mm);
    y_mm.emplace_back(p.after.y_mm);
    phi_rad.emplace_back(p.after.phi_rad);
  }
  return object_with("seq", std::move(seq), "in_sample", std::move(in_sample), "x_mm",
                     std::move(x_mm), "y_mm", std::move(y_mm), "phi_rad", std::move(phi_rad));
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
