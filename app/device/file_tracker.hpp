#pragma once
// A tracker that is known by the file its program writes: for instruments without another line.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/device/freshness.hpp"
#include "app/device/growing_file.hpp"
#include "app/device/nest_reading.hpp"
#include "app/files/points_file.hpp"

namespace trammel::device {

/// The points of a file that may hold no more than its header yet. Throws InputError for what is no
/// file of points.
std::vector<PointRow> points_so_far(const std::string& complete_lines, const std::string& name,
                                    const PointsOptions& format);

struct FileTrackerSettings {
  std::filesystem::path file;
  PointsOptions format;
  bool by_name = false;    // rows carry the nests' names; else they come in the order of the body
  double timeout_s = 120;  // from the end of the move to the last nest's row
  double poll_s = 0.2;
  NestSettings nests;
};

/// Waits, once the stage stands, for one complete new row a nest. A row that was begun before, or
/// has no newline yet, is none. A miss (0 0 0, empty, deleted) is `beam_broken`, no row in time, or
/// the last one again though the platform has moved, `timeout`, a file that has become shorter or
/// makes no sense a fault. Proof: file_tracker_test.cpp.
class FileTracker : public Tracker {
 public:
  explicit FileTracker(FileTrackerSettings settings)
      : settings_(std::move(settings)), file_(settings_.file) {}

  [[nodiscard]] std::string describe() const override;
  /// A file does not know whether the beam stands: always ok.
  [[nodiscard]] Status beam() override { return Status::ok; }
  PoseReport measure(const Occasion& occasion) override;

 private:
  /// Rows after the mark, one a nest; fewer while they are not all there.
  [[nodiscard]] std::vector<PointRow> rows_of_nests(const std::string& text) const;
  [[nodiscard]] PoseReport report_of(const std::vector<PointRow>& rows, bool moved);

  FileTrackerSettings settings_;
  GrowingFile file_;
  Freshness fresh_;
};

/// The weather record of the newest row of a tracker's points file, and `first_degc` while there is
/// no row yet; fault when rows carry no temperature.
std::unique_ptr<Thermometer> tracker_thermometer(std::filesystem::path file, PointsOptions format,
                                                 std::optional<double> first_degc);

}  // namespace trammel::device
