// What the models leave, as joint errors, against everything that was recorded.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/job/correction_json.hpp"
#include "app/report/page/source.hpp"
#include "app/terminal/counted.hpp"
#include "core/calibrate/correction.hpp"
#include "core/units.hpp"

namespace trammel::report {

namespace {

/// The readings a diagnosis used: fitted ones and those that only judge.
std::vector<Reading> readings_of(const Source& source, const store::Job& job) {
  std::vector<Reading> readings;
  const Seen seen = seen_by(source.measured, job);
  for (const Walk& walk : source.measured.walks) {
    const auto& used = job.data.sessions;
    if (std::find(used.begin(), used.end(), walk.session.id) == used.end()) continue;
    for (const Visit& v : walk.visits) {
      const bool judges = seen.standing(v.reading) == Standing::unseen;
      if (judges || v.reading.set == ReadingSet::identify) readings.push_back(v.reading);
    }
  }
  return readings;
}

std::vector<Eigen::Vector3d> left_by(const RobotModel& model,
                                     const std::vector<Reading>& readings) {
  std::vector<Eigen::Vector3d> left;
  for (const JointSample& s : samples_left(model, readings)) left.push_back(s.error_mm);
  return left;
}

Json optional_drawn(const std::optional<double>& value) {
  return value ? Json(drawn(*value)) : Json(nullptr);
}

/// What residuals are drawn against.
struct Axis {
  const char* name;
  double (*at)(const Reading& reading, const Moment& moment, int rail);
};
constexpr Axis kTravel = {"travel from home [mm]",
                          [](const Reading&, const Moment& m, int i) { return m.s_mm[i]; }};
constexpr Axis kGuide = {"travel along the guide from home [mm]",
                         [](const Reading&, const Moment& m, int i) { return m.guide_mm[i]; }};
constexpr Axis kAbbe = {
    "travel times lever arm [mm^2]",
    [](const Reading&, const Moment& m, int i) { return m.s_mm[i] * m.lever_mm[i]; }};
constexpr Axis kTurn = {"place within one turn of the screw [mm]",
                        [](const Reading&, const Moment& m, int i) {
                          const double lead = m.lead_mm[i];
                          return m.l_mm[i] - lead * std::floor(m.l_mm[i] / lead);
                        }};
constexpr Axis kDirection = {"direction of approach (-1, 0, 1)",
                             [](const Reading&, const Moment& m, int i) { return m.direction[i]; }};
constexpr Axis kTemperature = {"temperature [degC]", [](const Reading& r, const Moment&, int) {
                                 return r.conditions.temp_degc.value_or(0);
                               }};
constexpr Axis kTime = {"time [h]", [](const Reading& r, const Moment&, int) {
                          return r.conditions.time_s.value_or(0) / kSecondsPerHour;
                        }};
constexpr Axis kOrientation = {
    "phi [deg]", [](const Reading&, const Moment& m, int) { return deg_from_rad(m.pose.phi_rad); }};

Axis axis_of(const Effect& effect) {
  if (effect.name == "screw_periodic") return kTurn;
  if (effect.name == "guide_bow") return kGuide;
  if (effect.name == "guide_yaw") return kAbbe;
  switch (effect.needs.empty() ? Need::travel : effect.needs.front()) {
    case Need::travel:
      return kTravel;
    case Need::direction:
      return kDirection;
    case Need::temperature:
      return kTemperature;
    case Need::time:
      return kTime;
    case Need::orientation:
      return kOrientation;
  }
  return kTravel;
}

int n_drives(const RobotModel& model) { return model.nominal.kind->n_chains; }

/// "rail 1", "x axis": of each drive.
Json drive_names(const RobotModel& model) {
  Json names = Json::array();
  for (int k = 0; k < n_drives(model); ++k) names.push_back(drive_name(model.nominal, k));
  return names;
}

/// A diagnosis' robot and what it leaves of the readings. Their orientation is the robot's own:
/// what a tracker reads of it is coarser than all that is to be seen here, and would hide it.
struct Explained {
  std::vector<Reading> readings;
  RobotModel model;
  std::vector<Moment> moments;
  std::vector<Eigen::Vector3d> left;  // joint errors, mm
};

Json states_figure(const Explained& e, const std::vector<Eigen::Vector3d>& geometry) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < e.readings.size(); ++i) {
    const Reading& r = e.readings[i];
    const Moment& m = e.moments[i];
    Json rails = Json::array();
    for (int k = 0; k < n_drives(e.model); ++k) {
      rails.push_back(Json::array(
          {drawn(m.s_mm[k]), m.direction[k], drawn(geometry[i][k]), drawn(e.left[i][k])}));
    }
    rows.push_back({{"fitted", r.set == ReadingSet::identify},
                    {"time_h", optional_drawn(m.time_h)},
                    {"temp_degc", optional_drawn(r.conditions.temp_degc)},
                    {"rails", rails}});
  }
  return figure({"residuals", "Residual against displacement, direction, time and temperature",
                 fmt::format("Measured - simulated of {} as joint errors [mm] (place as "
                             "measured, orientation as the model has it), one colour a "
                             "rail; full marks fitted (in-sample), open marks unseen (held-out). "
                             "Above: the geometry alone. Below: with the named effects.",
                             terminal::counted(e.readings.size(), "reading"))},
                "residuals", {{"names", drive_names(e.model)}, {"readings", rows}});
}

/// What the effect does on the drives and guides that carry it, in the machine's words.
std::string sentence_on(const RobotModel& model, std::size_t which) {
  const ActiveEffect& active = model.effects[which];
  std::vector<int> rails;
  for (std::size_t k = 0; k < active.effect->parameters.size(); ++k) {
    const int rail = active.effect->parameters[k].rail;
    const bool carries = active.values[static_cast<Eigen::Index>(k)] != 0 && rail >= 0;
    if (carries && std::ranges::find(rails, rail) == rails.end()) rails.push_back(rail);
  }
  return sentence_of(*active.effect, model.nominal, rails);
}

/// Component and residual: what is left once all but this effect is taken out, and the effect.
Json effect_figure(const Explained& e, std::size_t which) {
  const Effect& effect = *e.model.effects[which].effect;
  const Axis axis = axis_of(effect);
  RobotModel without = e.model;
  without.effects.erase(without.effects.begin() + static_cast<std::ptrdiff_t>(which));
  const std::vector<Eigen::Vector3d> partial = left_by(without, e.readings);
  Json rails = Json::array();
  for (int k = 0; k < n_drives(e.model); ++k) {
    Json points = Json::array();
    for (std::size_t i = 0; i < e.readings.size(); ++i) {
      points.push_back(Json::array({drawn(axis.at(e.readings[i], e.moments[i], k)),
                                    drawn(partial[i][k]), drawn(partial[i][k] - e.left[i][k]),
                                    e.readings[i].set == ReadingSet::identify ? 1 : 0}));
    }
    rails.push_back(std::move(points));
  }
  return figure({"effect-" + effect.name, effect.name + ": the residual without it, and its curve",
                 sentence_on(e.model, which) +
                     fmt::format(". Joint errors [mm] of {}, with all but "
                                 "this effect taken out (full marks in-sample, open "
                                 "marks held-out); line: the effect as fitted.",
                                 terminal::counted(e.readings.size(), "reading"))},
                "effect", {{"names", drive_names(e.model)}, {"axis", axis.name}, {"rails", rails}});
}

const RobotModel* model_in(const Correction& correction) {
  const auto* model = std::get_if<ModelCorrection>(&correction);
  return model == nullptr ? nullptr : &model->model;
}

/// The step "geometry" of the chain that the job kept.
std::optional<RobotModel> geometry_step(const Json& details) {
  if (!details.contains("models")) return std::nullopt;
  for (const Json& step : details.at("models")) {
    if (step.at("name") != "geometry") continue;
    const Correction correction =
        job::correction_of(Json{{"correction", step.at("correction")}}.dump());
    if (const RobotModel* model = model_in(correction)) return *model;
  }
  return std::nullopt;
}

Json residual_items(const Source& source, const store::Job& job) {
  const Correction correction = job::correction_of(job.data.result_json);
  const RobotModel* model = model_in(correction);
  const auto geometry = geometry_step(Json::parse(job.data.result_json).at("details"));
  if (model == nullptr || !geometry) {
    return Json::array({absent("residuals", "Residuals", "This job kept no chain of models.")});
  }
  Explained e{.readings = readings_of(source, job), .model = *model, .moments = {}, .left = {}};
  for (Reading& r : e.readings) {
    const Prediction at = predict(e.model, r.conditions);
    if (!at.ok()) {
      return Json::array({absent("residuals", "Residuals",
                                 fmt::format("The model cannot reach reading seq {}.", r.seq))});
    }
    // the orientation is the model's, and so is what is not measured
    Eigen::Vector3d seen = at.pose.vector();
    for (int c = 0; c < 2; ++c) {
      if (e.model.nominal.measured[static_cast<std::size_t>(c)]) seen[c] = r.measured->vector()[c];
    }
    r.measured = Pose::from(seen);
    e.moments.push_back(at.moment);
  }
  e.left = left_by(e.model, e.readings);
  Json items = Json::array({states_figure(e, left_by(*geometry, e.readings))});
  for (std::size_t k = 0; k < e.model.effects.size(); ++k) items.push_back(effect_figure(e, k));
  return items;
}

}  // namespace

Json residual_section(const Source& source) {
  const char* title = "Residuals, and the named effect's curve through them";
  const auto diagnosis = source.jobs.find("diagnose");
  if (diagnosis == source.jobs.end()) return nullptr;
  try {
    return section("residuals", title, residual_items(source, diagnosis->second));
  } catch (const InputError& error) {
    return section("residuals", title,
                   Json::array({absent("residuals", "Residuals", error.what())}));
  }
}

}  // namespace trammel::report
