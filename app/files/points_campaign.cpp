#include "app/files/points_campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"

namespace trammel {

namespace {

constexpr std::size_t kMaxRawBytes = 90'000;  // the store keeps 100,000; more samples are cut

class ReadingMaker {
 public:
  ReadingMaker(const PointsFile& file, const Layout& layout, const Mechanism& mechanism,
               const Plan& plan)
      : file_(file), layout_(layout), mechanism_(mechanism), plan_(plan) {}

  PointsCampaign campaign() {
    require_dates();
    out_.poses = poses_of_points(file_, layout_, mechanism_.home, plan_);
    describe_campaign();
    make_readings();
    return std::move(out_);
  }

 private:
  void require_dates() const {
    const bool timed = std::any_of(file_.rows.begin(), file_.rows.end(),
                                   [](const PointRow& row) { return row.clock.has_value(); });
    if (!timed || file_.dates.order) return;
    refuse_points(file_, "the dates can be read two ways", file_.dates.why,
                  "points.date in the layout, or --date", "month-first or day-first");
  }

  void describe_campaign() {
    Campaign& c = out_.file.campaign;
    c.name = layout_.name;
    c.simulated = layout_.simulated;
    c.machine = machine_of(mechanism_);
    c.facts = layout_.facts;
    NestPose all = pose_of_nests(layout_.body.body, layout_.body, layout_.sigma_mm);
    c.tracker = TrackerSigma{std::sqrt((all.covariance(0, 0) + all.covariance(1, 1)) / 2),
                             std::sqrt(all.covariance(2, 2))};
    c.facts.emplace("points_file", std::filesystem::path(file_.name).filename().string());
    c.facts.emplace("points_format", file_.format);
    if (!file_.frame.empty()) c.facts.emplace("points_frame", file_.frame);
    if (!file_.program.empty()) c.facts.emplace("points_program", file_.program);
    for (const PointRow& row : file_.rows) {
      if (!row.clock) continue;
      first_s_ = clock_s(*row.clock, *file_.dates.order);
      out_.started = clock_text(*row.clock, *file_.dates.order);
      c.facts.emplace("started_tracker_clock", out_.started);
      break;
    }
  }

  void make_readings() {
    at_mm_ = from_mm_ = command(mechanism_.home, 0);
    std::vector<double> heights_mm;
    double square = 0;
    int last_pose = 0;
    for (const PointsPose& s : out_.poses.poses) {
      if (s.pose != last_pose) move_to(planned(plan_, s));
      last_pose = s.pose;
      if (!s.seen.ok()) continue;
      add_reading(s);
      heights_mm.push_back(s.seen.quality.height_mm);
      square += s.seen.quality.rms_mm * s.seen.quality.rms_mm;
      out_.out_of_plane_mm = std::max(out_.out_of_plane_mm, s.seen.quality.out_of_plane_mm);
    }
    if (heights_mm.empty())
      refuse_points(file_, "no pose is left", "0 readings", "poses of two nests or more");
    const auto [low, high] = std::minmax_element(heights_mm.begin(), heights_mm.end());
    out_.height_spread_mm = *high - *low;
    out_.rms_mm = std::sqrt(square / static_cast<double>(heights_mm.size()));
  }

  [[nodiscard]] Displacements command(const Pose& target, int seq) const {
    const InverseResult at = inverse(mechanism_.geometry, target);
    if (at.ok()) return at.l_mm;
    throw InputError(
        {.what = "the target is out of reach of chain " + std::to_string(at.chain + 1),
         .where = {.file = file_.name, .point = seq == 0 ? "home" : std::to_string(seq)}});
  }

  void move_to(const PlannedPoint& point) {
    const Displacements cmd_mm = command(point.target, point.seq);
    const PlannedMove move = planned_move(plan_, point, cmd_mm, at_mm_, from_mm_);
    at_mm_ = cmd_mm;
    from_mm_ = move.from_mm;
  }

  void add_reading(const PointsPose& s) {
    Reading r;
    r.seq = static_cast<int>(out_.file.campaign.readings.size()) + 1;
    r.set = planned(plan_, s).set;
    r.target = planned(plan_, s).target;
    r.conditions = {.cmd_mm = at_mm_, .from_mm = from_mm_, .epoch = s.epoch};
    r.measured = s.seen.pose;
    double sum_s = 0, sum_degc = 0;
    int n_s = 0, n_degc = 0;
    std::string& raw = out_.raw_reply[r.seq];
    for (const PointRow* row : s.used) {
      if (raw.size() + row->raw.size() < kMaxRawBytes) raw += (raw.empty() ? "" : "\n") + row->raw;
      if (row->clock) {
        sum_s += clock_s(*row->clock, *file_.dates.order) - first_s_;
        ++n_s;
      }
      if (row->temp_degc) {
        sum_degc += *row->temp_degc;
        ++n_degc;
      }
    }
    if (n_s > 0) r.conditions.time_s = sum_s / n_s;
    if (n_degc > 0) r.conditions.temp_degc = sum_degc / n_degc;
    out_.file.campaign.readings.push_back(std::move(r));
    out_.file.extras.emplace_back();
  }

  const PointsFile& file_;
  const Layout& layout_;
  const Mechanism& mechanism_;
  const Plan& plan_;
  Displacements at_mm_ = Displacements::Zero(), from_mm_ = Displacements::Zero();
  double first_s_ = 0;
  PointsCampaign out_;
};

}  // namespace

PointsCampaign campaign_of_points(const PointsFile& file, const Layout& layout,
                                  const Mechanism& mechanism, const Plan& plan) {
  validate(mechanism);
  return ReadingMaker(file, layout, mechanism, plan).campaign();
}

}  // namespace trammel
