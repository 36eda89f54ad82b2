#include "app/job/by_axis.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "app/terminal/counted.hpp"
#include "core/model/predictor.hpp"

namespace trammel::job {

namespace {

/// Measured less predicted, x and y of each reading of a set.
Eigen::Matrix2Xd left_of(const RobotModel& model, const Campaign& campaign, ReadingSet set) {
  std::vector<Eigen::Vector2d> all;
  const Predictor expected(model);
  for (const Reading& r : campaign.readings) {
    const Prediction at = expected.predict(r.conditions);
    if (r.set != set || !r.measured || !at.ok()) continue;
    all.emplace_back(r.measured->x_mm - at.pose.x_mm, r.measured->y_mm - at.pose.y_mm);
  }
  return Eigen::Map<const Eigen::Matrix2Xd>(all.empty() ? nullptr : all.front().data(), 2,
                                            static_cast<Eigen::Index>(all.size()));
}

std::string rms_um(const Eigen::Matrix2Xd& left) {
  const Eigen::Vector2d rms =
      1000 * left.rowwise().squaredNorm().cwiseSqrt() / std::sqrt(static_cast<double>(left.cols()));
  return fmt::format("{:.3f} and {:.3f} um", rms[0], rms[1]);
}

}  // namespace

std::string left_by_axis(const RobotModel& model, const Campaign& campaign) {
  const Machine& machine = model.nominal;
  if (machine.kind->n_chains != 2 || !machine.measured[0] || !machine.measured[1]) return "";
  const RobotModel stated = nominal_model(machine);
  const Eigen::Matrix2Xd fitted = left_of(stated, campaign, ReadingSet::identify);
  if (fitted.cols() == 0) return "";
  const Eigen::Vector2d offset = fitted.rowwise().mean();
  std::string text = "left in x and in y, rms";
  for (const ReadingSet set : {ReadingSet::identify, ReadingSet::validate}) {
    const Eigen::Matrix2Xd left = left_of(model, campaign, set);
    if (left.cols() == 0) continue;
    const Eigen::Matrix2Xd alone = left_of(stated, campaign, set).colwise() - offset;
    text += fmt::format(
        "{} {} on {} (offsets alone leave {})", set == ReadingSet::identify ? ":" : ",",
        rms_um(left),
        terminal::counted(left.cols(),
                          set == ReadingSet::identify ? "fitted reading" : "held-out reading"),
        rms_um(alone));
  }
  return text;
}

}  // namespace trammel::job
