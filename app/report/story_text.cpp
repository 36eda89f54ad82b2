#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "app/report/story.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/lines.hpp"
#include "app/terminal/text.hpp"

namespace trammel::report {

namespace {

using terminal::printable;

constexpr const char* kIndent = "           ";  // below the words of a line

std::string line(const char* what, const std::string& words) {
  if (words.empty()) return "";
  const std::string text = terminal::wrapped(kIndent + words, kIndent, true);
  return fmt::format("  {:<8} ", what) + text.substr(std::string_view(kIndent).size());
}

std::string sessions_text(const std::vector<PointsOf>& points, const char* verb) {
  std::string text;
  for (const PointsOf& p : points) {
    text += fmt::format("{}{} of {}", text.empty() ? "" : ", ", terminal::counted(p.n, "point"),
                        printable(p.session));
  }
  return text.empty() ? "" : std::string(verb) + text;
}

std::string named_text(const StoryRound& round) {
  std::string text;
  for (const EffectRow& e : round.effects) text += (text.empty() ? "" : " + ") + e.name;
  return text.empty() ? "nothing" : text;
}

std::string rivals_text(const StoryRound& round) {
  std::string text;
  for (const RivalRow& r : round.rivals) {
    text +=
        fmt::format("{}{} ({})", text.empty() ? "" : "; ", r.names,
                    r.structural ? "the same on these points" : fmt::format("{:.2g} : 1", r.odds));
  }
  return text;
}

std::string rms(const std::optional<double>& value, int decimals) {
  return value ? fmt::format("{:.{}f}", *value, decimals) : "-";
}

std::string gap_text(const StoryRound& round, int decimals) {
  std::string text;
  for (const GapRow& g : round.gap) {
    text +=
        fmt::format("{}{}{} {} / {}", text.empty() ? "" : ", ", g.tried ? "tried " : "", g.model,
                    rms(g.identify_rms_mm, decimals), rms(g.validate_rms_mm, decimals));
  }
  return text;
}

/// Two digits of the uncertainty, and no more of the value: "0.00404 +- 0.00026".
std::string with_uncertainty(double value, double U) {
  if (!(U > 0)) return fmt::format("{:g}", value);
  const int decimals = std::max(0, 1 - static_cast<int>(std::floor(std::log10(U))));
  return fmt::format("{:.{}f} +- {:.{}f}", value, decimals, U, decimals);
}

/// "k_1 = 0.00404 +- 0.00026, …".
std::string values_text(const EffectRow& effect) {
  std::string text;
  for (const EffectRow::Value& v : effect.values) {
    text += fmt::format("{}{} = {}{}", text.empty() ? "" : ", ", v.name,
                        with_uncertainty(v.value, 2 * v.std), v.unit == "1" ? "" : " " + v.unit);
  }
  for (const int seq : effect.seqs) text += fmt::format("{}seq {}", text.empty() ? "" : ", ", seq);
  return text;
}

std::string round_text(const StoryRound& round, std::size_t number, int decimals) {
  std::string text = fmt::format("round {}: {}\n", number, round.verdict);
  text += line("on", sessions_text(round.fitted, number > 1 ? "also " : ""));
  text += line("named", named_text(round));
  std::string tried;
  for (const std::string& name : round.tried) tried += (tried.empty() ? "" : ", ") + name;
  text += line("tried", tried);
  text += line("rivals", rivals_text(round));
  text += line("gap", gap_text(round, decimals));
  if (round.n_next_points > 0) {
    text +=
        line("next", fmt::format("measure {}: {}", terminal::counted(round.n_next_points, "point"),
                                 fmt::join(round.next_why, "; ")));
  }
  return text + line("job", fmt::format("{}, key {}", round.job_id, round.job_key.substr(0, 16)));
}

}  // namespace

std::string story_text(const std::vector<StoryRound>& story, int decimals) {
  if (story.empty()) return "";
  const StoryRound& last = story.back();
  const std::string judged = sessions_text(last.judged, "");
  std::string text = terminal::heading("Where simulation and measurement part, and why");
  text += terminal::wrapped(fmt::format(
      "gap: rms of measured - simulated per coordinate [mm], on fitted readings (in-sample) / on "
      "{}; "
      "a perfect model leaves {:.{}f}.",
      judged.empty() ? "unseen ones: none were measured" : judged + ", never fitted (held-out)",
      last.noise_floor_mm, decimals));
  for (std::size_t k = 0; k < story.size(); ++k) text += round_text(story[k], k + 1, decimals);
  if (!last.effects.empty()) text += "values of the last round, +-: U (k = 2):\n";
  for (const EffectRow& effect : last.effects) {
    text +=
        terminal::wrapped(fmt::format("  {}: {}", effect.name, values_text(effect)), "    ", true);
  }
  return text;
}

}  // namespace trammel::report
