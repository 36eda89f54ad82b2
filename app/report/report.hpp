#pragma once
// What a campaign's report says, as data: text and JSON (and later pages) are made from it.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "app/files/published_json.hpp"
#include "app/report/story.hpp"
#include "app/report/tolerance.hpp"
#include "core/judge/budget.hpp"
#include "core/judge/seen.hpp"
#include "core/statistics/summary.hpp"
#include "store/verify.hpp"

namespace trammel::report {

/// The method of a diagnosis in tables: the geometry with the effects that were named.
inline constexpr const char* kModel = "model";

/// What is asked of the model's position error: both must hold, the first where a perfect robot
/// would reach it from this baseline.
struct Demand {
  double improvement_pct = 90;
  double floor_ratio = 1.3;  // mean after over the mean length of a perfect reading
  double perfect_pct = 100;  // improvement that a perfect robot shows
  bool reached = false;

  [[nodiscard]] bool within_reach() const { return perfect_pct >= improvement_pct; }
};

/// One point of a table: where it was meant to be, and its errors.
struct PointError {
  double x_mm = 0, y_mm = 0;
  double before = 0, after = 0;
};

/// Errors of the same poses before and after a correction, mm or deg.
struct ErrorTable {
  std::string id = {};       // "lsq-80-position"
  std::string method = {};   // "lsq"
  std::string figure = {};   // "position", "attitude"
  std::string unit = {};     // "mm", "deg"
  std::string set = {};      // "identify", "validate"
  std::string session = {};  // of the readings before
  store::Id job = 0;
  Standing standing = Standing::unseen;  // to the fit
  bool after_predicted = false;  // by the correction from the readings before; else measured again
  Summary before = {};
  Summary after = {};
  int decimals = 4;                            // of its errors (terminal/decimals.hpp)
  std::optional<double> improvement_pct = {};  // none where the fit cannot know the epoch
  std::optional<PublishedTable> paper = {};    // what was printed beside it
  std::vector<PointError> points = {};         // in the order of measurement
  std::optional<Demand> demand = {};  // position of the model, where the noise floor is known

  [[nodiscard]] bool in_sample() const { return standing == Standing::fitted; }
};

/// Two methods on the same baseline readings, point by point: positive when `a` leaves more.
struct Contest {
  std::string a, b;
  int n = 0;
  int b_better = 0;               // points where b leaves the smaller error
  double mean_difference_mm = 0;  // a - b
  double half_width_mm = 0;       // 95 %: t s / sqrt(n)
};

/// The least-squares circle through measured points, less the circle that was asked for.
struct CircleDeviation {
  double centre_x_mm = 0, centre_y_mm = 0, radius_mm = 0;
};
struct CircleRow {
  std::string name = {};
  double x_mm = 0, y_mm = 0, radius_mm = 0;  // wanted
  int n = 0;
  CircleDeviation before = {};
  CircleDeviation after = {};
};
struct CircleTable {
  std::string method = {};  // whose correction "after" had
  bool after_predicted = false;
  std::vector<ErrorTable> errors = {};  // position, a table for each standing that it has
  std::vector<CircleRow> rows = {};     // of all points
};

/// The errors at the points that the fit has not seen, where there are any; else the first table.
const ErrorTable& most_unseen(const CircleTable& circles);

/// Mean of the absolute deviations over the circles, as the paper's Table XI has them.
CircleDeviation mean_deviation(const CircleTable& circles, CircleDeviation CircleRow::*side);

/// Where simulation and measurement are compared: all points, or those of a ring about O_A.
struct SimulationRow {
  double from_mm = 0, to_mm = 0;  // distance of the target from O_A
  int n = 0;
  double measured_mm = 0, simulated_mm = 0, left_mm = 0;  // means; left: of measured - simulated
};

/// Forward kinematics with the identified values against measurement (the paper's Figs. 7, 8).
struct SimulationTable {
  Standing standing = Standing::unseen;
  SimulationRow all = {};
  double left_max_mm = 0;
  std::vector<SimulationRow> rings = {};
};

/// One identified error source, mm or deg.
struct ParameterRow {
  std::string name = {};
  std::string unit = {};
  int epoch = 1;
  double value = 0;
  double standard_uncertainty = 0;
  bool identified = false;           // by itself; else the value means nothing alone
  bool dropped = false;              // as small, by repeated identification
  std::optional<double> paper = {};  // as published, where a value was
};
struct Identification {
  std::string job_key = {};
  int rank = 0;
  int columns = 0;
  std::vector<ParameterRow> parameters = {};
  std::vector<ParameterRow> combinations = {};  // "l_2 - R_2"
  std::vector<std::string> words = {};          // what is not identifiable
  double sigma_ratio = 0;                       // residuals over noise; 1 when noise explains all
  bool explained = true;                        // as far as chance goes, by the fit's own limit
  std::string why_attitude = {};                // how attitude was weighted, and what came of it
};

/// How well the network meets its own samples, mm (Table VIII).
struct NetworkFit {
  int neurons = 0;
  int n = 0;
  double sigma_mm = 0;                              // the common spread
  double least_sigma_mm = 0, largest_sigma_mm = 0;  // of the grid it was chosen from; 0: given
  double mae_mm = 0, mse_mm2 = 0;
  std::array<std::optional<double>, 3> r2_pearson;  // per joint
  std::array<std::optional<double>, 3> r2;          // 1 - SSE / SST
};

struct SessionRow {
  std::string name, plan, compensation;
  int n_points = 0, n_done = 0, n_readings = 0, n_epochs = 0;  // n_points: 0 without a plan
  bool counts = true;                                          // figures are made of it
};
struct JobRow {
  long long id = 0;
  std::string stage, key;
};

struct Report {
  std::string campaign = {};
  bool simulated = false;
  bool imported = false;
  std::string mechanism = {};                // one line
  std::string noise = {};                    // where the sigmas come from
  std::optional<double> floor_mean_mm = {};  // none: the noise is not known
  std::optional<double> floor_mean_deg = {};
  int decimals_mm = 4, decimals_deg = 4;  // of errors (terminal/decimals.hpp)
  int n_readings = 0;
  int n_excluded = 0;
  std::vector<ErrorTable> tables = {};
  std::optional<ToleranceTest> tolerance = {};  // where one was asked for
  std::optional<Contest> contest = {};
  std::string picked = {};  // by a contest of all methods over blocks of the fitted points
  std::optional<CircleTable> circles = {};
  std::optional<Identification> identification = {};
  std::vector<SimulationTable> simulation = {};
  std::vector<std::string> remarks = {};  // where a method makes something worse, and why
  std::optional<NetworkFit> network = {};
  std::vector<StoryRound> story = {};
  std::vector<SessionRow> sessions = {};
  std::vector<JobRow> jobs = {};
  std::vector<std::string> exclusions = {};  // "seq 7: beam hit by a sleeve"
  std::optional<Published> published = {};   // figures that were printed of such a campaign
  std::vector<BudgetRow> budget = {};        // of the correction of best_table; none without sigma
  std::vector<std::pair<std::string, std::string>> facts = {};  // the campaign's own
  std::string chain_head = {};                                  // SHA-256 over all readings
  std::optional<store::TakenOver> taken_over = {};  // from an older database, with its head there
};

/// Mean deviations of circles after a correction that were published, where they were.
std::optional<CircleDeviation> published_circles(const Report& report);

}  // namespace trammel::report
