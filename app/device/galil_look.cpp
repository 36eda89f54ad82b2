#include "app/device/galil_look.hpp"

#include <cmath>
#include <thread>

namespace trammel::device {

namespace {

constexpr double kRestMarginS = 2;  // beyond the time that the deceleration needs

}  // namespace

void wait_s(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

std::string each_axis(const std::string& question, const GalilAxes& axes) {
  std::string line;
  for (const GalilAxis& axis : axes) {
    line += (line.empty() ? "" : ";") + question + axis.letter;
  }
  return line;
}

std::string letters_of(const GalilAxes& axes) {
  std::string letters;
  for (const GalilAxis& axis : axes) letters += axis.letter;
  return letters;
}

GalilLook look_at(GalilWire& wire, const GalilAxes& axes) {
  const auto answers = wire.ask_numbers(each_axis("MG _BG", axes) + ";" + each_axis("TE", axes) +
                                        ";" + each_axis("SC", axes));
  GalilLook seen;
  const std::size_t n = axes.size();
  for (std::size_t i = 0; i < n; ++i) {
    seen.axes.push_back({.moves = answers[i] != 0,
                         .off_mm = axes[i].sign * answers[n + i] / axes[i].counts_per_mm(),
                         .stop_code = static_cast<int>(answers[2 * n + i])});
  }
  return seen;
}

std::vector<std::int64_t> ask_counts(GalilWire& wire, const GalilAxes& axes,
                                     const std::string& question) {
  const auto answers = wire.ask_numbers(each_axis(question, axes));
  std::vector<std::int64_t> counts;
  for (const double answer : answers) counts.push_back(std::llround(answer));
  return counts;
}

Displacements ask_displacements(GalilWire& wire, const GalilAxes& axes,
                                const std::string& question) {
  const auto at = ask_counts(wire, axes, question);
  Displacements l_mm = Displacements::Zero();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    l_mm[static_cast<int>(i)] = axes[i].mm(static_cast<double>(at[i]));
  }
  return l_mm;
}

bool bring_to_rest(GalilWire& wire, const GalilSettings& settings) {
  for (const std::string& stop : {"ST" + letters_of(settings.axes), std::string("AB1")}) {
    try {
      wire.command(stop);
    } catch (const GalilRefusal&) {
      continue;  // the next one is meant for this
    }
    const Deadline deadline =
        in_s(settings.speed_mm_s / settings.acceleration_mm_s2 + kRestMarginS);
    do {
      if (!look_at(wire, settings.axes).any_moves()) return true;
      wait_s(settings.poll_s);
    } while (std::chrono::steady_clock::now() < deadline);
  }
  return false;
}

}  // namespace trammel::device
