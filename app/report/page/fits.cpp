// How well each fit meets readings: simulated against measured, sensitivity, the network.

#include <fmt/format.h>

#include <cmath>

#include "app/job/correction_json.hpp"
#include "app/report/page/source.hpp"
#include "app/terminal/counted.hpp"
#include "core/calibrate/joint_error.hpp"
#include "core/calibrate/simulation.hpp"
#include "core/measure/noise.hpp"
#include "core/mechanism/machine_kinematics.hpp"
#include "core/mechanism/sensitivity.hpp"
#include "core/plan/grids.hpp"
#include "core/units.hpp"

namespace trammel::report {

namespace {

constexpr double kSensitivityHalfWidth_mm = 100, kSensitivityStep_mm = 10;

bool believes_a_robot(const Comparison& c) {
  return c.job->data.stage == "lsq" || c.job->data.stage == "geometry" ||
         c.job->data.stage == "diagnose";
}

Json three(const Eigen::Vector3d& error) {
  return Json::array({drawn(error[0]), drawn(error[1]), drawn(deg_from_rad(error[2]))});
}

Json sensitivity_figure(const Source& source) {
  const std::string title =
      "Share of each error source in the pose error" + of_the_paper(source, "Fig. 4");
  const SourceErrors errors;
  try {
    const Machine& machine = source.measured.campaign.machine;
    std::vector<Pose> poses = lattice(kSensitivityHalfWidth_mm, kSensitivityStep_mm);
    if (machine.kind->chain != &kPrrChain) {
      std::erase_if(poses, [&](const Pose& pose) { return !reach(machine, pose).ok(); });
    }
    const SensitivityShares shares = sensitivity(machine, poses, errors);
    Json sources = Json::array(), rows = Json::array();
    for (const MachineParameter& p : shares.sources) sources.push_back(p.name);
    for (Eigen::Index row = 0; row < shares.of.rows(); ++row) {
      Json values = Json::array();
      for (const double share : shares.of.row(row)) values.push_back(drawn(100 * share));
      rows.push_back(std::move(values));
    }
    return figure({"sensitivity", title,
                   fmt::format("Mean over {} poses within {:g} mm of O_A at phi = 0, for errors of "
                               "{:g} deg and {:g} mm; each row sums to 100 %. From the nominal "
                               "geometry alone: no reading enters.",
                               poses.size(), kSensitivityHalfWidth_mm,
                               deg_from_rad(errors.angle_rad), errors.length_mm)},
                  "sensitivity", {{"sources", sources}, {"rows", rows}});
  } catch (const InputError& error) {
    return absent("sensitivity", title, error.what());
  }
}

/// Per joint: what the map was told and what it says, in one set.
Json network_set(const Source& source, const MapCorrection& map,
                 const std::vector<Reading>& readings, const char* name) {
  const int n = source.measured.campaign.machine.kind->n_chains;
  Json joints = Json::array();
  for (int i = 0; i < n; ++i) joints.push_back(Json::array());
  for (const JointSample& s : merge_places(
           joint_samples(source.measured.campaign.machine, without_shifts(readings, map.epochs)))) {
    const Eigen::Vector3d says = joint_error_at(map.map, {s.x_mm, s.y_mm});
    for (int i = 0; i < n; ++i) {
      joints[static_cast<std::size_t>(i)].push_back(
          Json::array({drawn(s.error_mm[i]), drawn(says[i])}));
    }
  }
  return {{"name", name}, {"joints", joints}};
}

Json network_figure(const Source& source) {
  const std::string title = "Network against measurement" + of_the_paper(source, "Fig. 17");
  const auto rbf = source.jobs.find("rbf");
  if (rbf == source.jobs.end()) {
    return absent("network", title, "No network was trained: trammel calibrate rbf CAMPAIGN.");
  }
  const Correction correction = job::correction_of(rbf->second.data.result_json);
  const auto* map = std::get_if<MapCorrection>(&correction);
  if (map == nullptr) return absent("network", title, "This job's correction is not a map.");
  std::vector<Reading> seen, unseen;
  const Seen fitted = seen_by(source.measured, rbf->second);
  for (const Group& group : source.groups) {
    if (group.circles) continue;
    for (const Visit* v : group.visits) {
      const Standing standing = fitted.standing(v->reading);
      if (standing == Standing::fitted) seen.push_back(v->reading);
      if (standing == Standing::unseen) unseen.push_back(v->reading);
    }
  }
  try {
    Json sets = Json::array({network_set(source, *map, seen, "in-sample")});
    if (!unseen.empty()) sets.push_back(network_set(source, *map, unseen, "held-out"));
    const NetworkFit& fit = *source.report.network;
    return figure(
        {"network", title,
         fmt::format("Joint errors [mm] as measured and as the network gives them: {} "
                     "it learned (in-sample), {} it has not seen "
                     "(held-out). {}; in-sample MAE {:.4f} mm, MSE {:.6f} mm^2.",
                     terminal::counted(fit.n, "place"), terminal::counted(unseen.size(), "reading"),
                     terminal::counted(fit.neurons, "neuron"), fit.mae_mm, fit.mse_mm2)},
        "network", {{"sets", sets}});
  } catch (const InputError& error) {
    return absent("network", title, error.what());
  }
}

}  // namespace

Json simulated_figure(const Source& source, const Comparison& c) {
  if (!believes_a_robot(c)) return nullptr;
  const std::string id = "simulated-" + id_of(source, c);
  const std::string title = fmt::format(
      "Simulated against measured error: {}{}", words_of(c),
      c.job->data.stage == "lsq" && c.in_sample() ? of_the_paper(source, "Fig. 8") : "");
  std::vector<Reading> readings;
  for (const Pair& pair : c.paired.pairs) readings.push_back(pair.before->reading);
  Json measured = Json::array(), simulation = Json::array();
  try {
    for (const SimulatedError& e : simulated_errors(job::correction_of(c.job->data.result_json),
                                                    source.measured.campaign.machine, readings)) {
      measured.push_back(three(e.measured));
      simulation.push_back(three(e.simulated));
    }
  } catch (const InputError& error) {
    return absent(id, title, error.what());
  }
  Json axes = Json::array();  // of x, y and phi those that were measured
  for (int k = 0; k < 3; ++k) {
    if (source.measured.campaign.machine.measured[static_cast<std::size_t>(k)]) axes.push_back(k);
  }
  const auto& floor = source.report.floor_mean_mm;
  return figure({id, title,
                 fmt::format("{} before any compensation, {}. Each coordinate of the error "
                             "as the tracker read it and as the robot of this fit shows it{}.",
                             terminal::counted(measured.size(), "reading"), name_of(c.standing),
                             floor ? fmt::format("; sigma per coordinate {:.{}f} mm",
                                                 noise_level(source.measured.campaign).sigma.xy_mm,
                                                 decimals(source, Figure::position_mm))
                                   : "")},
                "simulated", {{"axes", axes}, {"measured", measured}, {"simulated", simulation}});
}

Json fit_section(const Source& source) {
  return section("fits", "Error sources, and the network's fit",
                 Json::array({sensitivity_figure(source), network_figure(source)}));
}

}  // namespace trammel::report
