#include "app/device/file_tracker.hpp"

#include <fmt/format.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <fstream>
#include <future>

#include "app/device/t2sa_wire.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using namespace trammel::device;

namespace {

const Occasion kNow{};
const std::vector<NestPoint> kTwoNests = {{"P1", {-75, 0, 0}}, {"P2", {75, 0, 0}}};

std::string row_of(const std::string& name, const Eigen::Vector3d& at_mm) {
  return fmt::format("A, platform, {}, {:.6f}, {:.6f}, {:.6f}, 11/27/26 14:00:00\n", name,
                     at_mm.x(), at_mm.y(), at_mm.z());
}

/// A file with a point of yesterday, as SpatialAnalyzer writes it.
struct Export {
  tests::TemporaryFolder folder;
  FileTrackerSettings settings;

  Export() {
    settings.file = folder.write(
        "points.txt", "// SpatialAnalyzer SA 2024.2\n// AXES = CARTESIAN: X, Y, Z (mm)\n" +
                          row_of("P1", {1000, 1000, 0}));
    settings.format.format = "sa";
    settings.nests.frame.body = kTwoNests;
    settings.nests.sigma_mm = 0.005;
    settings.timeout_s = 0.05;
    settings.poll_s = 0.001;
  }

  void append(const std::string& text) const {
    std::ofstream(settings.file, std::ios::binary | std::ios::app) << text;
  }
  /// Measures while `parts` are written, each after the file was read once more.
  PoseReport measure_during(const std::vector<std::string>& parts, double timeout_s = 10) {
    const int reads = ::inotify_init1(IN_CLOEXEC);
    ::inotify_add_watch(reads, settings.file.c_str(), IN_CLOSE_NOWRITE);
    const auto await_read = [&] {
      std::array<char, 4096> events{};
      return ::read(reads, events.data(), events.size()) > 0;
    };
    settings.timeout_s = timeout_s;
    FileTracker tracker(settings);
    auto report = std::async(std::launch::async, [&] { return tracker.measure(kNow); });
    for (const std::string& part : parts) {
      CHECK(await_read());
      append(part);
    }
    PoseReport result = report.get();
    ::close(reads);
    return result;
  }
};

}  // namespace

TEST_CASE("new rows of the nests, and no older ones, give the pose", "[device][file]") {
  Export file;
  const PoseReport report =
      file.measure_during({row_of("x", {-65, 20, 3}), row_of("y", {85, 20, 3})});
  INFO(report.detail);
  REQUIRE(report.ok());
  CHECK(report.pose.x_mm == Approx(10).margin(1e-9));
  CHECK(report.pose.y_mm == Approx(20).margin(1e-9));
  CHECK(std::abs(report.pose.phi_rad) < 1e-12);
  CHECK(report.raw_reply.find("-65.000000") != std::string::npos);
  CHECK(report.raw_reply.find("1000.0") == std::string::npos);
}

TEST_CASE("a half-written last line is no reading, and no reading is a timeout", "[device][file]") {
  Export file;
  std::string half = row_of("y", {85, 20, 3});
  half.pop_back();
  const PoseReport waits = file.measure_during({row_of("x", {-65, 20, 3}), half}, 0.1);
  CHECK(waits.status == Status::timeout);
  CHECK_THAT(waits.detail, Catch::Matchers::Contains("1 of 2 new rows"));
  // What is completed now was begun before this measurement: it belongs to the one before.
  const PoseReport report =
      file.measure_during({"\n", row_of("x", {-60, 30, 3}), row_of("y", {90, 30, 3}).substr(0, 30),
                           row_of("y", {90, 30, 3}).substr(30)});
  INFO(report.detail);
  REQUIRE(report.ok());
  CHECK(report.pose.x_mm == Approx(15).margin(1e-9));
}

TEST_CASE("rows by name may come in any order, among others; the newer one counts",
          "[device][file]") {
  Export file;
  file.settings.by_name = true;
  const PoseReport report = file.measure_during(
      {row_of("B1", {0, 0, 0}) + row_of("P2", {999, 0, 0}) + row_of("P2", {75, 1, 0}),
       row_of("P1", {-75, 1, 0})});
  INFO(report.detail);
  REQUIRE(report.ok());
  CHECK(report.pose.y_mm == Approx(1).margin(1e-9));
}

TEST_CASE("a miss is a broken beam", "[device][file]") {
  Export file;
  const PoseReport report =
      file.measure_during({row_of("x", {-65, 20, 3}) + row_of("y", {0, 0, 0})});
  CHECK(report.status == Status::beam_broken);
  CHECK_THAT(report.detail, Catch::Matchers::Contains("line 5 is a miss"));
}

TEST_CASE("rows that make no sense are a fault", "[device][file]") {
  Export file;
  const PoseReport report =
      file.measure_during({"A, platform, P1, no, number, here, 11/27/26 14:00:00\n"});
  CHECK(report.status == Status::fault);
  CHECK_THAT(report.detail, Catch::Matchers::Contains(":4:"));
}

TEST_CASE("a file that is begun anew is told, one that is not there yet is empty",
          "[device][file]") {
  Export file;
  GrowingFile growing(file.settings.file);
  growing.mark();
  CHECK_FALSE(growing.grown());
  file.folder.write("points.txt", "x\n");
  CHECK_THROWS_AS(growing.grown(), DeviceError);
  GrowingFile later(file.folder.path() / "later.txt");
  later.mark();
  CHECK_FALSE(later.grown());
  file.folder.write("later.txt", "1 2 3\n4 5");
  CHECK(later.grown() == "1 2 3\n");
  CHECK(later.lines_before() == 0);
  CHECK_FALSE(later.grown());
}

TEST_CASE("the tracker's own weather record is that of its newest row", "[device][temperature]") {
  const tests::TemporaryFolder folder;
  const std::string header = "X  [mm],Y  [mm],Z  [mm],Temperature  [C],Delete\n";
  const auto file = folder.write("p.csv", header);
  PointsOptions format;
  format.format = "leica-csv";
  const auto thermometer = tracker_thermometer(file, format, 19.5);
  CHECK(thermometer->describe() ==
        "weather record of the tracker in " + file.string() + ", 19.5 degC before its first row");
  CHECK(thermometer->read(kNow).temp_degc == 19.5);
  CHECK(tracker_thermometer(file, format, {})->read(kNow).status == Status::timeout);
  folder.write("p.csv", header + "1,2,3,20.25,FALSE\n1,2,3,20.75,FALSE\n1,2,3,99");
  CHECK(thermometer->read(kNow).temp_degc == 20.75);
  folder.write("p.csv", header + "1,2,3,,FALSE\n");
  CHECK(thermometer->read(kNow).status == Status::fault);
}
