#include "app/job/contest_text.hpp"

#include <fmt/format.h>

namespace trammel::job {

namespace {

std::string depends_on(const Json& row) {
  std::string text;
  for (const auto& [name, share] : row["depends_on"].items()) {
    text +=
        fmt::format("{}{} ({:.0f} %)", text.empty() ? "" : ", ", name, 100 * share.get<double>());
  }
  return text;
}

std::string line(const Json& row, const Json& timing, const std::string& picked) {
  const std::string method = row["method"].get<std::string>();
  if (row.contains("failed")) {
    return fmt::format("  {:<20} could not run: {}\n", method, row["failed"].get<std::string>());
  }
  return fmt::format("{} {:<20}{:9.4f}{:9.4f}{:9.4f}{:9.3f}  {}\n", method == picked ? ">" : " ",
                     method, row["mean_mm"].get<double>(), row["p95_mm"].get<double>(),
                     row["max_mm"].get<double>(), timing.value(method + "_s", 0.0),
                     depends_on(row));
}

}  // namespace

std::string contest_table(const Json& details, const Json& timing) {
  if (!details.contains("table") || !details.contains("picked")) return {};
  std::string text = fmt::format("  {:<20}{:>9}{:>9}{:>9}{:>9}  {}\n", "held-out, mm", "mean",
                                 "95 %", "max", "time, s", "what is left goes with");
  for (const Json& row : details["table"]) {
    text += line(row, timing, details["picked"].get<std::string>());
  }
  return text;
}

}  // namespace trammel::job
