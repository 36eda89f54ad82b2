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
  return {axes[0].letter, axes[1].letter, axes[2].letter};
}

GalilLook look_at(GalilWire& wire, const GalilAxes& axes) {
  const auto answers = wire.ask_numbers(each_axis("MG _BG", axes) + ";" + each_axis("TE", axes) +
                                        ";" + each_axis("SC", axes));
  GalilLook seen;
  for (std::size_t i = 0; i < kChains; ++i) {
    seen.moves[i] = answers[i] != 0;
    seen.off_mm[i] = axes[i].sign * answers[kChains + i] / axes[i].counts_per_mm();
    seen.stop_code[i] = static_cast<int>(answers[2 * kChains + i]);
  }
  return seen;
}

std::array<std::int64_t, kChains> ask_counts(GalilWire& wire, const GalilAxes& axes,
                                             const std::string& question) {
  const auto answers = wire.ask_numbers(each_axis(question, axes));
  std::array<std::int64_t, kChains> counts{};
  for (std::size_t i = 0; i < kChains; ++i) counts[i] = std::llround(answers[i]);
  return counts;
}

Displacements ask_displacements(GalilWire& wire, const GalilAxes& axes,
                                const std::string& question) {
  const auto at = ask_counts(wire, axes, question);
  return {axes[0].mm(static_cast<double>(at[0])), axes[1].mm(static_cast<double>(at[1])),
          axes[2].mm(static_cast<double>(at[2]))};
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
