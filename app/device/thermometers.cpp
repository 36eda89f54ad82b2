#include "app/device/thermometers.hpp"

#include <fmt/format.h>

#include <utility>

#include "app/device/growing_file.hpp"
#include "app/files/numbers.hpp"
#include "core/error.hpp"

namespace trammel::device {

namespace {

constexpr double kColdestDegc = -50, kHottestDegc = 100;  // beyond: no temperature of a workshop

class FixedThermometer : public Thermometer {
 public:
  explicit FixedThermometer(double temp_degc) : temp_degc_(temp_degc) {}
  [[nodiscard]] std::string describe() const override {
    return fmt::format("fixed at {} degC", temp_degc_);
  }
  TemperatureReport read(const Occasion&) override { return {Status::ok, "", temp_degc_}; }

 private:
  double temp_degc_;
};

/// A last line, and the number at its end.
std::optional<double> number_at_end(std::string_view lines) {
  constexpr std::string_view kSeparators = " \t\r\n,;";
  const std::size_t end = lines.find_last_not_of(kSeparators);
  if (end == std::string_view::npos) return std::nullopt;
  lines = lines.substr(0, end + 1);
  const std::size_t before = lines.find_last_of(kSeparators);
  return parse_number(before == std::string_view::npos ? lines : lines.substr(before + 1));
}

class LoggedThermometer : public Thermometer {
 public:
  LoggedThermometer(std::filesystem::path file, double max_age_s)
      : file_(std::move(file)), max_age_s_(max_age_s) {}
  [[nodiscard]] std::string describe() const override { return "logged in " + file_.string(); }

  TemperatureReport read(const Occasion&) override {
    try {
      const std::optional<double> age = age_s(file_);
      if (!age) return {Status::timeout, file_.string() + " is not there"};
      if (*age > max_age_s_) {
        return {Status::timeout, fmt::format("{} is {:.0f} s old, at most {} are allowed",
                                             file_.string(), *age, max_age_s_)};
      }
      const auto degc = number_at_end(complete_lines(file_));
      if (degc && *degc >= kColdestDegc && *degc <= kHottestDegc) return {Status::ok, "", *degc};
      return {Status::fault, "the last line of " + file_.string() + " ends with no temperature"};
    } catch (const DeviceError& error) {
      return {Status::fault, error.what()};
    }
  }

 private:
  std::filesystem::path file_;
  double max_age_s_;
};

}  // namespace

std::unique_ptr<Thermometer> fixed_thermometer(double temp_degc) {
  return std::make_unique<FixedThermometer>(temp_degc);
}

std::unique_ptr<Thermometer> logged_thermometer(std::filesystem::path file, double max_age_s) {
  return std::make_unique<LoggedThermometer>(std::move(file), max_age_s);
}

}  // namespace trammel::device
