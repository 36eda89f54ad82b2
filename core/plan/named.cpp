#include "core/plan/named.hpp"

#include <array>

#include "core/error.hpp"

namespace trammel {

namespace {

constexpr int kUnmeasured = 48;  // the paper's second set

std::vector<TargetGroup> single(std::vector<Pose> poses) { return {{"", std::move(poses)}}; }

std::vector<TargetGroup> circles() {
  std::vector<TargetGroup> groups;
  for (const Circle& c : paper_circles()) {
    groups.push_back({"circle " + std::to_string(groups.size() + 1), circle(c)});
  }
  return groups;
}

struct Named {
  const char* name;
  std::vector<TargetGroup> (*groups)();
};
const std::array<Named, 4> kGrids = {{
    {"paper-80", [] { return single(paper_80()); }},
    {"paper-48", [] { return single(paper_48()); }},
    {"paper-48-farthest", [] { return single(farthest_points(paper_80(), kUnmeasured)); }},
    {"circles", &circles},
}};

}  // namespace

const std::vector<std::string>& grid_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Named& grid : kGrids) all.emplace_back(grid.name);
    return all;
  }();
  return names;
}

std::vector<TargetGroup> named_groups(const std::string& name) {
  std::string known;
  for (const Named& grid : kGrids) {
    if (name == grid.name) return grid.groups();
    known += (known.empty() ? "" : ", ") + std::string(grid.name);
  }
  throw UsageError({.what = "no such grid", .got = name, .expected = known});
}

Plan named_plan(const std::string& name, ReadingSet set) {
  PlanRequest request{.name = name, .groups = named_groups(name)};
  request.set = set;
  return build_plan(request);
}

}  // namespace trammel
