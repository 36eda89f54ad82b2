#include "app/device/thermometers.hpp"

#include <chrono>

#include "tests/support/catch.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using namespace trammel::device;

namespace {

const Occasion kAnytime{};
constexpr double kTenMinutesS = 600;

}  // namespace

TEST_CASE("each thermometer says where its number is from", "[device][temperature]") {
  CHECK(fixed_thermometer(20.5)->describe() == "fixed at 20.5 degC");
  CHECK(fixed_thermometer(20.5)->read(kAnytime).temp_degc == 20.5);
  CHECK(logged_thermometer("room.csv", kTenMinutesS)->describe() == "logged in room.csv");
}

TEST_CASE("a logger's last complete line is read, while it is fresh", "[device][temperature]") {
  const tests::TemporaryFolder folder;
  const auto file = folder.write("room.csv", "time,degC\n14:00,20.25\n14:01,20.5\r\n14:02,9");
  const auto thermometer = logged_thermometer(file, kTenMinutesS);
  CHECK(thermometer->read(kAnytime).temp_degc == 20.5);
  std::filesystem::last_write_time(
      file, std::filesystem::file_time_type::clock::now() - std::chrono::seconds(700));
  const TemperatureReport old = thermometer->read(kAnytime);
  CHECK(old.status == Status::timeout);
  CHECK_THAT(old.detail, Catch::Matchers::Contains("700 s old"));
}

TEST_CASE("a log without a temperature at its end is told, and never taken for one",
          "[device][temperature]") {
  const tests::TemporaryFolder folder;
  for (const char* text : {"", "time,degC\n", "14:00,nan\n", "14:00,451\n", "14:00 20.5 C\n"}) {
    CAPTURE(text);
    const auto file = folder.write("room.csv", text);
    CHECK(logged_thermometer(file, kTenMinutesS)->read(kAnytime).status == Status::fault);
  }
  CHECK(logged_thermometer(folder.path() / "none", kTenMinutesS)->read(kAnytime).status ==
        Status::timeout);
}
