#include "app/files/points_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "app/files/numbers.hpp"
#include "core/error.hpp"

namespace trammel {

namespace {

constexpr std::size_t kMaxNameBytes = 300;  // the matcher recurses once a character

[[noreturn]] void refuse_row(const PointsFile& file, const PointRow& row, const std::string& what,
                             const std::string& expected, const std::string& hint = "") {
  const std::string called = row.group.empty() ? row.name : row.group + "/" + row.name;
  throw InputError({.what = what,
                    .where = {.file = file.name, .line = row.line, .field = "name"},
                    .got = "'" + called + "'",
                    .expected = expected,
                    .hint = hint});
}

/// Reads names by the layout's templates.
class NameReader {
 public:
  NameReader(const PointsFile& file, const Layout& layout)
      : file_(file), layout_(layout), point_(layout.rows.point), group_(layout.rows.group) {}

  /// pose, nest and, where the template has it, repeat.
  [[nodiscard]] std::map<std::string, std::string> read(const PointRow& row) const {
    auto found = point_.match(row.name);
    if (found && !layout_.rows.group.empty()) {
      const auto of_group = group_.match(row.group);
      if (of_group) {
        found->insert(of_group->begin(), of_group->end());
      } else {
        found.reset();
      }
    }
    if (found) return *found;
    const std::string& group = layout_.rows.group;
    refuse_row(file_, row, "the name does not fit the layout",
               (group.empty() ? "" : group + "/") + layout_.rows.point,
               "rows.point and rows.group of " + layout_.file + " say how names are made");
  }

 private:
  const PointsFile& file_;
  const Layout& layout_;
  NamePattern point_, group_;
};

bool is_nest(const std::vector<NestPoint>& nests, const std::string& name) {
  return std::any_of(nests.begin(), nests.end(),
                     [&name](const NestPoint& n) { return n.nest == name; });
}

AssignedRows by_name_of(const PointsFile& file, const Layout& layout, const Plan& plan) {
  AssignedRows assigned;
  const NameReader reader(file, layout);
  std::map<std::pair<int, int>, std::size_t> place;  // of (pose, repeat)
  std::map<std::pair<int, std::string>, int> seen;   // rows of a nest at a pose so far
  bool at_base = false;
  for (const PointRow& row : file.rows) {
    if (row.miss == Miss::deleted) continue;
    if (is_nest(layout.frame.base, row.name)) {
      const bool again = at_base && assigned.base.back().rows.contains(row.name);
      if (!at_base || again) assigned.base.push_back({assigned.poses.size(), {}});
      assigned.base.back().rows[row.name].push_back(&row);
      at_base = true;
      continue;
    }
    at_base = false;
    const auto names = reader.read(row);
    const int pose = parse_integer(names.at("pose")).value_or(0);
    const std::string& nest = names.at("nest");
    if (pose < 1 || pose > static_cast<int>(plan.points.size())) {
      refuse_row(file, row, "the plan has no such pose",
                 fmt::format("1 to {}", plan.points.size()));
    }
    if (!is_nest(layout.body.body, nest)) {
      refuse_row(file, row, "neither the platform nor the base has nest " + nest, "a nest");
    }
    int repeat = ++seen[{pose, nest}];
    if (names.contains("repeat")) repeat = parse_integer(names.at("repeat")).value_or(0);
    if (layout.rows.mean_of_samples) repeat = 1;
    const auto [at, is_new] = place.try_emplace({pose, repeat}, assigned.poses.size());
    if (is_new) assigned.poses.push_back({pose, repeat, {}});
    auto& rows = assigned.poses[at->second].rows[nest];
    rows.push_back(&row);
    if (rows.size() > 1 && !layout.rows.mean_of_samples) {
      refuse_row(file, row,
                 fmt::format("pose {}, repeat {} has nest {} already", pose, repeat, nest),
                 "each once", fmt::format("first in line {}", rows.front()->line));
    }
  }
  return assigned;
}

/// Walks the rows in the order that the layout states.
class InOrder {
 public:
  InOrder(const PointsFile& file, const Layout& layout, const Plan& plan)
      : file_(file), layout_(layout), plan_(plan) {
    for (const PointRow& row : file.rows) {
      if (row.miss != Miss::deleted) rows_.push_back(&row);
    }
  }

  AssignedRows assigned() {
    const Layout::Rows& rows = layout_.rows;
    const int n_poses = static_cast<int>(plan_.points.size());
    base();
    for (int pose = 1; pose <= n_poses; ++pose) {
      for (int repeat = 1; repeat <= rows.repeats; ++repeat) {
        if (repeat == 1 || !rows.mean_of_samples) out_.poses.push_back({pose, repeat, {}});
        for (const std::string& nest : rows.nests) {
          out_.poses.back().rows[nest].push_back(&next(nest));
        }
      }
      if (base_after(pose)) base();
    }
    if (at_ != rows_.size()) refuse_count();
    return std::move(out_);
  }

 private:
  [[nodiscard]] bool base_after(int pose) const {
    const int every = layout_.rows.base_every;
    return every > 0 && (pose % every == 0 || pose == static_cast<int>(plan_.points.size()));
  }

  [[noreturn]] void refuse_count() const {
    const int n_poses = static_cast<int>(plan_.points.size());
    int n_base = layout_.frame.base.empty() ? 0 : 1;
    for (int pose = 1; pose <= n_poses && n_base > 0; ++pose) n_base += base_after(pose) ? 1 : 0;
    const std::size_t expected = static_cast<std::size_t>(n_poses) *
                                     static_cast<std::size_t>(layout_.rows.repeats) *
                                     layout_.rows.nests.size() +
                                 static_cast<std::size_t>(n_base) * layout_.frame.base.size();
    throw InputError(
        {.what = "the number of rows is not that of the plan",
         .where = {.file = file_.name},
         .got = std::to_string(rows_.size()),
         .expected = fmt::format("{} = {} poses x {} repeats x {} nests + {} x {} base nests",
                                 expected, n_poses, layout_.rows.repeats, layout_.rows.nests.size(),
                                 n_base, layout_.frame.base.size()),
         .hint = "a miss must keep its row; or map by name"});
  }

  const PointRow& next(const std::string& nest) {
    if (at_ == rows_.size()) refuse_count();
    const PointRow& row = *rows_[at_++];
    // SpatialAnalyzer counts the points of a group: such a name says nothing about the nest.
    const bool named = !row.name.empty() && file_.format != "sa";
    if (named && row.name != nest) {
      refuse_row(file_, row, "this row is out of turn", nest, "is a row missing above?");
    }
    return row;
  }

  void base() {
    if (layout_.frame.base.empty()) return;
    out_.base.push_back({out_.poses.size(), {}});
    for (const NestPoint& nest : layout_.frame.base) {
      out_.base.back().rows[nest.nest].push_back(&next(nest.nest));
    }
  }

  const PointsFile& file_;
  const Layout& layout_;
  const Plan& plan_;
  std::vector<const PointRow*> rows_;  // less the deleted ones, which were shot again
  AssignedRows out_;
  std::size_t at_ = 0;
};

}  // namespace

NamePattern::NamePattern(const std::string& pattern) {
  std::string expression;
  for (std::size_t at = 0; at < pattern.size();) {
    const std::size_t close = pattern[at] == '{' ? pattern.find('}', at) : std::string::npos;
    const std::string place =
        close == std::string::npos ? "" : pattern.substr(at + 1, close - at - 1);
    if (place == "pose" || place == "nest" || place == "repeat") {
      expression += place == "nest" ? "(.+)" : "0*([0-9]{1,9})";
      places_.push_back(place);
      at = close + 1;
    } else {
      if (std::ispunct(static_cast<unsigned char>(pattern[at])) != 0) expression += '\\';
      expression += pattern[at++];
    }
  }
  expression_ = std::regex(expression);
}

std::optional<std::map<std::string, std::string>> NamePattern::match(
    const std::string& text) const {
  std::smatch found;
  if (text.size() > kMaxNameBytes || !std::regex_match(text, found, expression_)) {
    return std::nullopt;
  }
  std::map<std::string, std::string> values;
  for (std::size_t k = 0; k < places_.size(); ++k) values[places_[k]] = found[k + 1].str();
  return values;
}

AssignedRows assign_rows(const PointsFile& file, const Layout& layout, const Plan& plan) {
  return layout.rows.by_name ? by_name_of(file, layout, plan)
                             : InOrder(file, layout, plan).assigned();
}

}  // namespace trammel
