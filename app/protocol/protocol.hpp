#pragma once
// A whole campaign as data: what to measure, calibrate and measure again, in order.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/plan/plan.hpp"

namespace trammel::protocol {

/// A session: a plan walked through, baseline or under the correction of an earlier step.
struct MeasureStep {
  std::string plan;                 // "paper-80", "paper-48", "circles"
  std::string next_points_of = {};  // in place of a plan: the points this diagnose step suggests
  Approach approach = {0, 0, 0};    // of every point
  ReadingSet set = ReadingSet::identify;
  std::optional<std::string> compensate = {};  // name of a calibrate or diagnose step
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

/// Its name is the name of the session, or finds the job: by it a resume knows what is done.
struct Step {
  std::string name;
  std::variant<MeasureStep, CalibrateStep, DiagnoseStep> what;
};

struct Protocol {
  std::string name;  // of the campaign
  std::string about;
  std::filesystem::path robot;  // the virtual robot's file
  std::string published = {};   // the campaign's fact (app/files/published_json.hpp); "": none
  std::vector<Step> steps;
};

/// Reads a file of the form protocol/1 (schemas/protocol.schema.json), as strict as the schema, and
/// beyond it: names are not repeated, and steps name earlier ones of the right kind. Throws
/// InputError with line, column and path. Proof: protocol_test.cpp.
Protocol read_protocol(const std::filesystem::path& path);

/// The same from text; `path` is where it would stand: errors name it, the robot is beside it.
Protocol parse_protocol(std::string_view text, const std::filesystem::path& path);

}  // namespace trammel::protocol
