#pragma once
// A whole campaign as data: what to measure, calibrate and measure again, in order.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "app/job/grid.hpp"
#include "app/session/policy.hpp"
#include "core/plan/check.hpp"

namespace trammel::protocol {

/// What is measured with, and under which rules. A step changes what it names of the protocol's.
struct Setting {
  std::string stage;            // "sim:FILE", "galil:FILE", with the file's whole path
  std::string tracker = "sim";  // "sim", "t2sa:FILE", "file:FILE", the same
  session::Policy policy = {};
  CheckOptions check = {};
};

/// In place of a plan: the points that this diagnose step suggests.
struct NextPointsOf {
  std::string step;
};
using PlanSource = std::variant<job::GridRequest, std::filesystem::path, NextPointsOf>;

/// A session: a plan walked through, baseline or under the correction of an earlier step.
struct MeasureStep {
  PlanSource plan;
  std::optional<ReadingSet> set = {};          // of all points; none: as the plan has it
  std::optional<std::string> compensate = {};  // name of a calibrate or diagnose step
  Setting setting = {};
  std::filesystem::path plan_check = {};  // record that the plan is safe; a real stage asks for it
  bool new_set_up = false;                // homed and framed anew: an epoch of its own

  /// The points are known when a diagnosis has suggested them.
  [[nodiscard]] bool suggested() const { return std::holds_alternative<NextPointsOf>(plan); }
};

/// A job on what earlier steps measured.
struct CalibrateStep {
  std::string method;                                                    // "lsq", "idw", "rbf"
  std::vector<std::string> sessions;                                     // names of measure steps
  nlohmann::ordered_json parameters = nlohmann::ordered_json::object();  // that differ from default
};

/// The discrepancy workflow on what earlier steps measured. Sessions of suggested points that were
/// skipped are left out.
struct DiagnoseStep {
  std::vector<std::string> sessions;  // names of measure steps; their validate readings only judge
  nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
};

/// A person acts before the next measure step begins. Once that has begun it is done.
struct PauseStep {
  std::string ask;  // "put nest 2 on"
};

/// Files that are written anew each time; a tolerance that is not shown to be met ends the run.
struct ReportStep {
  std::filesystem::path text, json, html, dcc;  // empty: none
  std::optional<double> tolerance_mm = {};
};

/// Its name is the name of the session, or finds the job: by it a resume knows what is done.
struct Step {
  std::string name;
  std::variant<MeasureStep, CalibrateStep, DiagnoseStep, PauseStep, ReportStep> what;
};

struct Protocol {
  std::string name;  // of the campaign
  std::string about;
  std::string published = {};  // the campaign's fact (app/files/published_json.hpp); "": none
  std::vector<Step> steps;
};

/// Reads a file of the form protocol/1 (schemas/protocol.schema.json), as strict as the schema, and
/// beyond it: names are not repeated, and steps name earlier ones of the right kind. Throws
/// InputError with line, column and path. Proof: protocol_test.cpp.
Protocol read_protocol(const std::filesystem::path& path);

/// The same from text; `path` is where it would stand: errors name it, other files are beside it.
Protocol parse_protocol(std::string_view text, const std::filesystem::path& path);

}  // namespace trammel::protocol
