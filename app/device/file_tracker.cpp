#include "app/device/file_tracker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "app/device/tcp.hpp"
#include "core/error.hpp"

namespace trammel::device {

namespace {

class TrackerThermometer : public Thermometer {
 public:
  TrackerThermometer(std::filesystem::path file, PointsOptions format,
                     std::optional<double> first_degc)
      : file_(std::move(file)), format_(std::move(format)), first_degc_(first_degc) {}

  [[nodiscard]] std::string describe() const override {
    std::string text = "weather record of the tracker in " + file_.string();
    if (first_degc_) text += fmt::format(", {} degC before its first row", *first_degc_);
    return text;
  }

  TemperatureReport read(const Occasion&) override {
    try {
      const auto rows = points_so_far(complete_lines(file_), file_.string(), format_);
      if (!rows.empty()) return of_row(rows.back());
      if (first_degc_) return {Status::ok, "", *first_degc_};
      return {Status::timeout, file_.string() + " has no row yet: state `first_degc`"};
    } catch (const Error& error) {
      return {Status::fault, error.what()};
    }
  }

 private:
  [[nodiscard]] TemperatureReport of_row(const PointRow& row) const {
    if (row.temp_degc) return {Status::ok, "", *row.temp_degc};
    return {Status::fault,
            fmt::format("line {} of {} has no temperature", row.line, file_.string())};
  }

  std::filesystem::path file_;
  PointsOptions format_;
  std::optional<double> first_degc_;
};

}  // namespace

std::vector<PointRow> points_so_far(const std::string& complete_lines, const std::string& name,
                                    const PointsOptions& format) {
  int n_lines = 0;  // but for comments
  for (std::size_t at = 0; at < complete_lines.size(); at = complete_lines.find('\n', at) + 1) {
    const std::string_view line = std::string_view(complete_lines).substr(at, 2);
    const bool comment = line == "//" || line.starts_with('#') || line.starts_with('%');
    if (!comment && line != "\r\n" && !line.starts_with('\n')) ++n_lines;
  }
  if (n_lines == 0) return {};
  try {
    return parse_points(complete_lines, name, format).rows;
  } catch (const InputError&) {
    if (n_lines == 1) return {};  // the names of the columns
    throw;
  }
}

std::string FileTracker::describe() const {
  return "tracker by the file " + settings_.file.string();
}

std::vector<PointRow> FileTracker::rows_of_nests(const std::string& text) const {
  const std::vector<NestPoint>& body = settings_.nests.frame.body;
  std::vector<PointRow> found;
  for (const PointRow& row : points_so_far(text, settings_.file.string(), settings_.format)) {
    if (row.line <= file_.lines_before() || found.size() == body.size()) continue;
    const auto is_body = [&](const NestPoint& nest) { return nest.nest == row.name; };
    const auto is_row = [&](const PointRow& before) { return before.name == row.name; };
    if (!settings_.by_name) {
      found.push_back(row);
      found.back().name = body[found.size() - 1].nest;
    } else if (std::any_of(body.begin(), body.end(), is_body)) {
      // Measured twice: the newer row counts.
      const auto before = std::find_if(found.begin(), found.end(), is_row);
      before == found.end() ? found.push_back(row) : void(*before = row);
    }
  }
  return found;
}

PoseReport FileTracker::report_of(const std::vector<PointRow>& rows, bool moved) {
  std::vector<NestPoint> points;
  std::string raw;
  for (const PointRow& row : rows) {
    raw += (raw.empty() ? "" : "\n") + row.raw;
    points.push_back({row.name, row.at_mm});
  }
  for (const PointRow& row : rows) {
    if (!row.miss) continue;
    return {Status::beam_broken,
            fmt::format("line {} is a miss ({})", row.line, name_of(*row.miss)),
            {},
            raw};
  }
  for (const NestPoint& p : points) {
    const std::string why =
        fresh_.look_at_values(p.nest, {p.at_mm.x(), p.at_mm.y(), p.at_mm.z()}, moved);
    if (!why.empty()) return {Status::timeout, "nest " + p.nest + ": " + why, {}, raw};
  }
  PoseReport report = pose_report(points, settings_.nests, raw);
  if (report.ok()) fresh_.taken();
  return report;
}

PoseReport FileTracker::measure(const Occasion& occasion) {
  try {
    file_.mark();
    const Deadline deadline = in_s(settings_.timeout_s);
    std::size_t n_found = 0;
    const std::size_t n_nests = settings_.nests.frame.body.size();
    for (;;) {
      if (const auto text = file_.grown()) {
        const std::vector<PointRow> rows = rows_of_nests(*text);
        n_found = rows.size();
        const bool moved = occasion.moved_mm > kMovedSigmas * settings_.nests.sigma_mm;
        if (n_found == n_nests) return report_of(rows, moved);
      }
      if (std::chrono::steady_clock::now() >= deadline) {
        return {Status::timeout, fmt::format("{} of {} new rows in {} s in {}", n_found, n_nests,
                                             settings_.timeout_s, settings_.file.string())};
      }
      std::this_thread::sleep_for(std::chrono::duration<double>(settings_.poll_s));
    }
  } catch (const Error& error) {  // the file can't be read, or is no file of points
    return {Status::fault, error.what()};
  }
}

std::unique_ptr<Thermometer> tracker_thermometer(std::filesystem::path file, PointsOptions format,
                                                 std::optional<double> first_degc) {
  return std::make_unique<TrackerThermometer>(std::move(file), std::move(format), first_degc);
}

}  // namespace trammel::device
