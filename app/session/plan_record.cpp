#include "app/session/plan_record.hpp"

#include <fmt/format.h>

#include <array>

#include "app/files/files.hpp"
#include "app/files/plan_json.hpp"
#include "app/session/settings.hpp"
#include "core/error.hpp"
#include "store/clock.hpp"
#include "store/machine.hpp"
#include "store/provenance.hpp"

namespace trammel::session {

namespace {

constexpr std::size_t kMaxRecordBytes = 1'000'000;
constexpr const char* kHint =
    "`trammel plan check PLAN --mechanism FILE --record CHECK`, then `session run … --plan-check "
    "CHECK`";

/// Which way a margin is stricter.
struct Strict {
  const char* key;
  double CheckOptions::*value;
  bool larger;
};
constexpr std::array<Strict, 6> kStrict = {{
    {"limit_margin_mm", &CheckOptions::limit_margin_mm, true},
    {"singularity_margin", &CheckOptions::singularity_margin, true},
    {"link_clearance_mm", &CheckOptions::link_clearance_mm, true},
    {"speed_mm_s", &CheckOptions::speed_mm_s, true},
    {"max_speed_mm_s", &CheckOptions::max_speed_mm_s, false},
    {"max_platform_mm_s", &CheckOptions::max_platform_mm_s, false},
}};

}  // namespace

std::string plan_sha256(const Plan& plan, const Mechanism& mechanism) {
  store::Digest digest;
  digest << "trammel/plan-record/1" << plan.approach_mm << static_cast<int>(plan.points.size());
  for (const PlannedPoint& p : plan.points) {
    digest << p.seq << p.target.x_mm << p.target.y_mm << p.target.phi_rad;
    for (const int direction : p.approach) digest << direction;
  }
  digest << machine_of(mechanism);
  return store::hex(digest.finish());
}

void write_plan_record(const std::filesystem::path& file, const Plan& plan,
                       const Mechanism& mechanism, const CheckOptions& check, Existing existing) {
  const nlohmann::ordered_json json = {{"schema", "trammel/plan-record/1"},
                                       {"plan", plan.name},
                                       {"n_points", plan.points.size()},
                                       {"plan_sha256", plan_sha256(plan, mechanism)},
                                       {"check", check_json(check)},
                                       {"checked_utc", store::utc_now()},
                                       {"tool_version", store::this_program().tool_version}};
  write_output(file, json.dump(1) + "\n", existing);
}

PlanRecord read_plan_record(const std::filesystem::path& file) {
  const std::string text = read_file(file, kMaxRecordBytes);
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    if (json.at("schema") != "trammel/plan-record/1") {
      throw InputError({.what = "this is no record of a plan check",
                        .where = {.file = file.string(), .field = "schema"},
                        .hint = kHint});
    }
    return {json.at("plan_sha256").get<std::string>(), read_check(json.at("check"))};
  } catch (const nlohmann::json::exception& error) {
    throw InputError({.what = "the record of a plan check cannot be read",
                      .where = {.file = file.string()},
                      .got = error.what(),
                      .hint = kHint});
  }
}

std::vector<std::string> missing_record(const std::string& file, const Plan& plan,
                                        const Mechanism& mechanism, const CheckOptions& check) {
  const std::string sha256 = plan_sha256(plan, mechanism);
  if (file.empty()) {
    return {fmt::format("a real stage needs a check of this plan ({}): {}", sha256.substr(0, 12),
                        kHint)};
  }
  const PlanRecord record = read_plan_record(file);
  if (record.plan_sha256 != sha256) {
    return {fmt::format("{} is of another plan or mechanism ({}, this is {}): {}", file,
                        record.plan_sha256.substr(0, 12), sha256.substr(0, 12), kHint)};
  }
  std::vector<std::string> missing;
  for (const Strict& s : kStrict) {
    const double was = record.check.*s.value, is = check.*s.value;
    if (s.larger ? was >= is : was <= is) continue;
    missing.push_back(fmt::format("{} was checked with {} {:g}, this run has {:g}: {}", file, s.key,
                                  was, is, kHint));
  }
  return missing;
}

}  // namespace trammel::session
