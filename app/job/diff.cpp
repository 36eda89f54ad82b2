#include "app/job/diff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "app/job/points.hpp"
#include "app/job/run.hpp"
#include "app/job/text.hpp"
#include "app/terminal/counted.hpp"
#include "core/judge/deviation.hpp"
#include "core/units.hpp"

namespace trammel::job {

namespace {

constexpr std::size_t kPointsShown = 10;

void collect(const std::string& path, const Json& a, const Json& b, Json& out) {
  if (a == b) return;
  const auto at = [&path](const std::string& key) { return path.empty() ? key : path + "." + key; };
  if (a.is_object() && b.is_object()) {
    for (const auto& [key, value] : a.items()) {
      collect(at(key), value, b.contains(key) ? b[key] : Json(), out);
    }
    for (const auto& [key, value] : b.items()) {
      if (!a.contains(key)) collect(at(key), Json(), value, out);
    }
  } else if (a.is_array() && b.is_array() && a.size() == b.size()) {
    for (std::size_t k = 0; k < a.size(); ++k) {
      collect(path + "[" + std::to_string(k) + "]", a[k], b[k], out);
    }
  } else {
    out.push_back({{"path", path}, {"a", a}, {"b", b}});
  }
}

/// Statistics by "set metric (judged)", so that rows of one name meet.
Json by_name(const std::vector<store::Statistic>& statistics) {
  Json all = Json::object();
  for (Json& row : statistics_json(statistics)) {
    const std::string name =
        fmt::format("{} {} ({})", row["set"].get<std::string>(), row["metric"].get<std::string>(),
                    row["in_sample"].get<bool>() ? "in-sample" : "held-out");
    for (const char* taken : {"set", "metric", "in_sample"}) row.erase(taken);
    all[name] = std::move(row);
  }
  return all;
}

bool same_point(const store::JobPoint& a, const store::JobPoint& b) {
  return a.seq == b.seq && a.in_sample == b.in_sample && a.after == b.after;
}

using Points = std::vector<store::JobPoint>;

Json point_differences(const Points& a, const Points& b) {
  std::map<int, const store::JobPoint*> of_b;
  for (const store::JobPoint& p : b) of_b.emplace(p.seq, &p);
  Json all = Json::array();
  for (const store::JobPoint& p : a) {
    const auto found = of_b.find(p.seq);
    if (found == of_b.end() || same_point(p, *found->second)) continue;
    const store::JobPoint& q = *found->second;
    const Pose moved = Pose::from(pose_difference(q.after, p.after));
    all.push_back({{"seq", p.seq},
                   {"in_sample", {p.in_sample, q.in_sample}},
                   {"after_mm", {position_error_mm(p.after, {}), position_error_mm(q.after, {})}},
                   {"moved_mm", position_error_mm(moved, {})},
                   {"moved_deg", deg_from_rad(attitude_error_rad(moved, {}))}});
  }
  std::stable_sort(all.begin(), all.end(), [](const Json& x, const Json& y) {
    return x["moved_mm"].get<double>() > y["moved_mm"].get<double>();
  });
  return all;
}

std::set<int> seqs_of(const Points& points) {
  std::set<int> seqs;
  for (const store::JobPoint& p : points) seqs.insert(p.seq);
  return seqs;
}

Json only_in(const std::set<int>& a, const std::set<int>& b) {
  Json all = Json::array();
  for (const int seq : a) {
    if (!b.contains(seq)) all.push_back(seq);
  }
  return all;
}

/// The exclusions `job` honoured, with their reasons.
std::vector<store::Exclusion> honoured(store::Connection& connection, const store::NewJob& job) {
  std::vector<store::Exclusion> all = store::exclusions(connection, job.campaign_id);
  std::erase_if(all, [&job](const store::Exclusion& e) {
    return std::ranges::find(job.exclusions, e.id) == job.exclusions.end();
  });
  return all;
}

Json exclusions_without(store::Connection& connection, const store::NewJob& a,
                        const store::NewJob& b) {
  Json all = Json::array();
  for (const store::Exclusion& e : honoured(connection, a)) {
    if (a.campaign_id == b.campaign_id &&
        std::ranges::find(b.exclusions, e.id) != b.exclusions.end()) {
      continue;
    }
    all.push_back({{"seq", e.seq}, {"reason", e.reason}});
  }
  return all;
}

std::string value_text(const Json& value) { return value.is_null() ? "-" : value.dump(); }

std::string rows_text(const char* title, const Json& rows) {
  if (rows.empty()) return "";
  std::string text = fmt::format("{}\n", title);
  for (const Json& row : rows) {
    text += fmt::format("  {:<46} {:>22} {:>22}\n", row["path"].get<std::string>(),
                        value_text(row["a"]), value_text(row["b"]));
  }
  return text;
}

std::string exclusions_text(const Json& side, const Json& id) {
  std::string text;
  for (const Json& e : side) {
    text += fmt::format("  only job {} leaves out seq {}: {}\n", id.get<store::Id>(),
                        e["seq"].get<int>(), e["reason"].get<std::string>());
  }
  return text;
}

std::string points_text(const Json& d) {
  const Json& points = d["points"];
  std::string text;
  for (const char* side : {"a", "b"}) {
    const std::size_t n = d["readings_only_in"][side].size();
    if (n > 0)
      text += fmt::format("  {} only in job {}\n", terminal::counted(n, "reading"),
                          d[side].get<store::Id>());
  }
  if (points.empty()) return text;
  text += fmt::format("position error after, mm: {} of {} common readings differ, most first\n",
                      points.size(), d["common_readings"].get<std::size_t>());
  for (std::size_t k = 0; k < std::min(points.size(), kPointsShown); ++k) {
    const Json& p = points[k];
    text += fmt::format("  seq {:<7} {:>9.4f} {:>9.4f}   apart {:.4f} mm, {:.4f} deg\n",
                        p["seq"].get<int>(), p["after_mm"][0].get<double>(),
                        p["after_mm"][1].get<double>(), p["moved_mm"].get<double>(),
                        p["moved_deg"].get<double>());
  }
  if (points.size() > kPointsShown) {
    text += fmt::format("  and {} more (--json has all)\n", points.size() - kPointsShown);
  }
  return text;
}

}  // namespace

Json json_differences(const Json& a, const Json& b) {
  Json out = Json::array();
  collect("", a, b, out);
  return out;
}

Json changed_parts(const store::JobKey& then, const store::JobKey& now) {
  Json changed = Json::array();
  for (const auto& [part, digest] : now.parts) {
    const auto at = then.parts.find(part);
    if (at != then.parts.end() && at->second == digest) continue;
    changed.push_back({{"part", part},
                       {"then", at == then.parts.end() ? Json() : Json(at->second)},
                       {"now", digest}});
  }
  return changed;
}

std::string outcome_text(const store::NewJob& job) {
  Json result = Json::parse(store::canonical_json(job.result_json, "result"));
  result.erase("timing");
  std::vector<std::string> lines;  // in an order of their own: a pulled file has another than ours
  for (const Json& one : statistics_json(job.statistics)) lines.push_back(one.dump());
  std::ranges::sort(lines);
  std::string text = result.dump();
  for (const std::string& line : lines) text += "\n" + line;
  return text;
}

bool same_outcome(const store::NewJob& a, const store::NewJob& b) {
  return outcome_text(a) == outcome_text(b);
}

Json job_differences(store::Connection& connection, const store::Job& a, const store::Job& b) {
  const Points points_a = points_of(connection, a), points_b = points_of(connection, b);
  const std::set<int> in_a = seqs_of(points_a), in_b = seqs_of(points_b);
  const bool one_campaign = a.data.campaign_id == b.data.campaign_id;
  const Json only_a = only_in(in_a, in_b);
  return {
      {"a", a.id},
      {"b", b.id},
      {"same_campaign", one_campaign},
      {"same_key", a.data.key.key == b.data.key.key},
      {"same_result", same_outcome(a.data, b.data)},
      {"changed", changed_parts(key_today(connection, a), key_today(connection, b))},
      {"settings", json_differences(
                       {{"stage", a.data.stage}, {"algorithm_version", a.data.algorithm_version}},
                       {{"stage", b.data.stage}, {"algorithm_version", b.data.algorithm_version}})},
      {"parameters",
       json_differences(Json::parse(a.data.parameters_json), Json::parse(b.data.parameters_json))},
      {"exclusions_only_in",
       {{"a", exclusions_without(connection, a.data, b.data)},
        {"b", exclusions_without(connection, b.data, a.data)}}},
      {"statistics", json_differences(by_name(a.data.statistics), by_name(b.data.statistics))},
      {"readings_only_in",
       {{"a", one_campaign ? only_a : Json::array()},
        {"b", one_campaign ? only_in(in_b, in_a) : Json::array()}}},
      {"common_readings", one_campaign ? in_a.size() - only_a.size() : 0},
      {"points", one_campaign ? point_differences(points_a, points_b) : Json::array()}};
}

std::string job_differences_text(const Json& d) {
  std::string text;
  for (const Json& c : d["changed"]) {
    text += (text.empty() ? "" : ", ") + c["part"].get<std::string>();
  }
  text = text.empty() ? "the inputs are the same" : "inputs that differ: " + text;
  text += d["same_result"].get<bool>() ? "; the results are the same bit for bit\n"
                                       : "; the results differ\n";
  if (!d["same_campaign"].get<bool>()) text += "they are of two campaigns: no point is compared\n";
  const std::string title = fmt::format("{:<48} {:>22} {:>22}", "what differs",
                                        fmt::format("job {}", d["a"].get<store::Id>()),
                                        fmt::format("job {}", d["b"].get<store::Id>()));
  Json rows = d["settings"];
  for (const char* part : {"parameters", "statistics"}) {
    for (const Json& row : d[part]) rows.push_back(row);
  }
  text += rows_text(title.c_str(), rows);
  for (const char* side : {"a", "b"}) {
    text += exclusions_text(d["exclusions_only_in"][side], d[side]);
  }
  return text + points_text(d);
}

std::vector<std::string> stale_words(store::Connection& connection, const store::Job& job,
                                     const store::NewJob& now) {
  std::vector<std::string> words;
  for (const Json& changed : changed_parts(job.data.key, now.key)) {
    const std::string part = changed["part"];
    if (part == "algorithm_version") {
      words.push_back(fmt::format("algorithm_version: {} is version {} now, it was {}", now.stage,
                                  now.algorithm_version, job.data.algorithm_version));
    } else if (part == "exclusions") {
      for (const Json& e : exclusions_without(connection, now, job.data)) {
        words.push_back(fmt::format("exclusions: seq {} is left out now: {}", e["seq"].get<int>(),
                                    e["reason"].get<std::string>()));
      }
    } else if (part == "readings") {
      words.push_back(
          fmt::format("readings: {} now, {} then", now.n_readings, job.data.n_readings));
    } else if (part == "parameters") {
      for (const Json& d : json_differences(Json::parse(job.data.parameters_json),
                                            Json::parse(now.parameters_json))) {
        words.push_back(fmt::format("parameters: {} is {} now, it was {}",
                                    d["path"].get<std::string>(), value_text(d["b"]),
                                    value_text(d["a"])));
      }
    } else {
      words.push_back(part);
    }
  }
  return words;
}

}  // namespace trammel::job
