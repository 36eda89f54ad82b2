#include "app/report/page/item.hpp"

#include <cmath>

#include "app/files/numbers.hpp"

namespace trammel::report {

Json figure(const FigureHead& head, const char* kind, Json data) {
  return {{"type", "figure"}, {"id", head.id},           {"title", head.title},
          {"kind", kind},     {"caption", head.caption}, {"data", std::move(data)}};
}

Json absent(const std::string& id, const std::string& title, const std::string& why) {
  return {{"type", "figure"}, {"id", id}, {"title", title}, {"absent", why}};
}

Json table(const FigureHead& head, const std::vector<std::string>& columns, Json rows) {
  return {{"type", "table"},         {"id", head.id},      {"title", head.title},
          {"caption", head.caption}, {"columns", columns}, {"rows", std::move(rows)}};
}

Json sentences(const std::string& id, const std::string& title, std::vector<std::string> lines,
               const std::string& none) {
  if (lines.empty()) lines.push_back(none);
  return {{"type", "sentences"}, {"id", id}, {"title", title}, {"lines", std::move(lines)}};
}

Json fold(const std::string& id, const std::string& title, bool open, Json items) {
  return {
      {"type", "fold"}, {"id", id}, {"title", title}, {"open", open}, {"items", std::move(items)}};
}

Json section(const std::string& id, const std::string& title, Json items,
             const std::vector<std::string>& words) {
  return {{"id", id}, {"title", title}, {"words", words}, {"items", std::move(items)}};
}

double drawn(double value) {
  const double size = std::abs(value);
  if (size >= 0.001 || size < 1e-7) return rounded(value, 5);
  return rounded(value, 2 - static_cast<int>(std::floor(std::log10(size))));
}

double magnification(double largest, double wanted) {
  if (!(largest > 0)) return 1;
  const double power = std::pow(10.0, std::floor(std::log10(wanted / largest)));
  for (const double step : {5.0, 2.0}) {
    if (step * power * largest <= wanted) return step * power;
  }
  return power;
}

}  // namespace trammel::report
