#include "app/job/diagnosis_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/terminal/counted.hpp"
#include "app/terminal/lines.hpp"
#include "core/plan/plan.hpp"

namespace trammel::job {

namespace {

constexpr const char* kIndent = "             ";  // below the words of a line
constexpr double kStructure = 0.01;  // a corrected p above this is no structure worth a place
constexpr std::size_t kPlaces = 3;

std::string p_text(double p) { return p < 1e-12 ? "p < 1e-12" : fmt::format("p = {:.2g}", p); }

/// Four decimals, or as many as show three digits of a number: a stage of micrometres has no
/// "0.0000 mm".
std::string digits(double value) {
  const double size = std::abs(value);
  const int decimals =
      size >= 0.1 || size == 0 ? 4 : 2 - static_cast<int>(std::floor(std::log10(size)));
  return fmt::format("{:.{}f}", value, std::max(4, decimals));
}

std::string joined(const Json& names, const char* separator) {
  std::string text;
  for (const Json& n : names) text += (text.empty() ? "" : separator) + n.get<std::string>();
  return text;
}

std::string with_unit(double value, const Json& unit) {
  return fmt::format("{:.2g}{}", value, unit == "1" ? "" : " " + unit.get<std::string>());
}

/// A sentence under its word: "  expected   one reading is …", broken to fit a terminal.
std::string line(const char* word, const std::string& sentence) {
  if (sentence.empty()) return "";
  const std::string text = terminal::wrapped(kIndent + sentence, kIndent, true);
  return fmt::format("  {:<10} ", word) + text.substr(std::string_view(kIndent).size());
}

std::string names_of(const Json& effects) {
  Json names = Json::array();
  for (const Json& e : effects) names.push_back(e["name"]);
  return joined(names, " + ");
}

/// The headline follows from the verdict; what was named only fills it in.
std::string verdict_text(const Json& d) {
  const std::string verdict = d["verdict"], named = names_of(d["effects"]);
  if (d.contains("base_distance") && d["base_distance"].contains("implausible")) {
    return "if this is a 3-PRR, it is not the one that is stated: " +
           d["base_distance"]["implausible"].get<std::string>() +
           "; nothing is named with confidence, and nothing added to the model";
  }
  if (verdict == "nothing_missing") {
    return "nothing is missing that these readings could show (see 'design': what they could not)";
  }
  if (verdict == "explained") {
    return named == "outlier_readings" ? "single wrong readings are all that is wrong"
                                       : "what the model is missing is " + named;
  }
  if (verdict == "ambiguous") {
    return named + " explains the gap, and so does another set: these readings don't decide";
  }
  if (!d["suspect"].empty()) {
    return "before any effect, something gross is wrong: " +
           d["suspect"][0]["what"].get<std::string>();
  }
  return "there is structure that no effect of the catalogue explains; nothing is added to the "
         "model";
}

/// Gross mistakes, two hypotheses where both fit alike.
std::string suspect_text(const Json& d) {
  std::string text;
  for (const Json& s : d["suspect"]) {
    text += line(text.empty() ? "suspect" : "or",
                 fmt::format("{}: {}; {}", s["kind"].get<std::string>(),
                             s["what"].get<std::string>(), s["why"].get<std::string>()));
  }
  return text;
}

/// Effects beside the named ones that the average over sets does not rule out; of a named effect
/// the parameters that it was not named with.
std::string possible_text(const Json& d) {
  std::string text;
  for (const Json& e : d["may_also_hold"]) {
    const bool named = std::ranges::any_of(
        d["effects"], [&](const Json& other) { return other["name"] == e["name"]; });
    std::string which;
    for (const Json& p : e["parameters"]) {
      if (named) which += (which.empty() ? " on " : ", ") + p["name"].get<std::string>();
    }
    text += fmt::format("{}{}{} ({:.0f} %)", text.empty() ? "" : ", ", e["name"].get<std::string>(),
                        which, 100 * e["probability"].get<double>());
  }
  return line("may also", text.empty() ? text : "hold: " + text);
}

std::string far_text(const Json& d) {
  std::string text;
  for (const Json& r : d["suspicious_readings"]) {
    text += fmt::format("{}{} ({:.1f})", text.empty() ? "seq " : ", ", r["seq"].get<int>(),
                        r["sigmas"].get<double>());
  }
  return line("far", text.empty() ? text
                                  : text +
                                        " sigma: the noise has heavy tails, which explain them; "
                                        "they count less");
}

/// "0.0100 mm and 0.0040 deg"; without the angle where none is measured.
std::string sizes(const Json& noise, const char* mm, const char* deg) {
  std::string text = digits(noise[mm]) + " mm";
  return noise.contains(deg) ? text + " and " + digits(noise[deg]) + " deg" : text;
}

std::string noise_text(const Json& d) {
  const std::string source = d["noise_source"];
  const Json& n = d["noise"];
  std::string text = fmt::format("a perfect model leaves {} of a reading (1 sigma, from {})",
                                 sizes(n, "sigma_xy_mm", "sigma_phi_deg"),
                                 n["rescaled"].get<bool>() ? "what base and catalogue leave"
                                 : source == "tracker"     ? "the tracker's statement"
                                 : source == "repeats"     ? "repeated readings"
                                                           : "what the best model leaves");
  if (n["rescaled"].get<bool>()) {
    const bool stated = n.contains("stated_xy_mm");
    text += fmt::format("; {} {}, but white residuals of another size are noise, not structure",
                        stated ? "the tracker states" : "the repeats alone say",
                        stated ? sizes(n, "stated_xy_mm", "stated_phi_deg")
                               : sizes(n["repeats"], "sigma_xy_mm", "sigma_phi_deg"));
  }
  if (n["correlation"].get<double>() != 0) {
    text += fmt::format("; successive readings are correlated by {:.2f}, taken out before testing",
                        n["correlation"].get<double>());
  }
  return text;
}

std::string expected_text(const Json& d) {
  std::string text = line("expected", noise_text(d));
  const Json& r = d["readings"];
  const int epochs = r["epochs"], unseen = r["validate"];
  const std::string further = epochs > 1
                                  ? fmt::format(", with joint zeros and frame of {},",
                                                terminal::counted(epochs - 1, "further epoch"))
                                  : "";
  text += line("", fmt::format("the complete geometry{} is fitted to {}; {}", further,
                               terminal::counted(
                                   r["identify"].get<int>() - r["left_out"].get<int>(), "reading"),
                               unseen == 1  ? "1 other only judges"
                               : unseen > 0 ? fmt::format("{} others only judge", unseen)
                                            : "none are left to judge"));
  return text;
}

/// What the residuals of a model show: the corrected p, and where.
std::string test_text(const char* word, const std::string& of, const Json& test) {
  const double p = test["family_p"];
  std::string text =
      line(word, fmt::format("{}: {} (of {} tests the smallest, corrected for them all)", of,
                             p_text(p), test["tests"].get<int>()));
  if (p > kStructure) return text;
  std::size_t shown = 0;
  for (const Json& f : test["findings"]) {
    const std::string where = f["where"];
    if (f["p"].get<double>() * test["tests"].get<int>() > kStructure) continue;
    if (where.starts_with("effect ") || shown == kPlaces) continue;
    ++shown;
    text += line("", fmt::format("where: {}{}, {}", where,
                                 f["when"] == "all" ? "" : ", " + f["when"].get<std::string>(),
                                 p_text(f["p"])));
  }
  return text;
}

std::string suspects_text(const Json& d) {
  std::string text;
  for (const Json& s : d["suspects"]) {
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", s["effect"].get<std::string>(),
                        p_text(s["p"]));
  }
  return line("could be", text);
}

std::string tried_text(const Json& d) {
  std::string text;
  for (const Json& c : d["considered"]) {
    text += line(
        text.empty() ? "lost" : "",
        fmt::format("{}: worse by {:.1f} (chi^2, names and parameters paid for){}",
                    joined(c["names"], " + "), c["behind_chi2"].get<double>(),
                    c["usual"].get<bool>() ? "" : "; needs a sign that the effect can't have"));
  }
  return text;
}

std::string effect_text(const char* word, const Json& e) {
  if (e.contains("seq")) {
    std::string seqs;
    for (const Json& s : e["seq"]) seqs += (seqs.empty() ? "" : ", ") + s.dump();
    return line(word,
                "outlier_readings: seq " + seqs + " (left out of all fits; nothing is deleted)");
  }
  std::string text = line(
      word, fmt::format("{}: {}", e["name"].get<std::string>(), e["sentence"].get<std::string>()));
  text += line("", fmt::format("{:.1f} % of what was explained, {}",
                               100 * e["share_of_gap"].get<double>(), p_text(e["p"])));
  for (const Json& p : e["parameters"]) {
    const bool chosen = p["std"] == 0.0;  // among some, not fitted
    text += fmt::format("{}{:<5} = {:>12.5g} {}{}\n", kIndent, p["name"].get<std::string>(),
                        p["value"].get<double>(),
                        chosen ? p["unit"].get<std::string>() + " (the best that was tried)"
                               : "+- " + with_unit(p["std"], p["unit"]) + " (1 sigma)",
                        p.contains("unusual") ? "  unusual: outside its usual range" : "");
  }
  return text;
}

std::string rivals_text(const Json& d) {
  std::string text;
  if (!d.contains("rival_odds")) {
    return d["considered"].empty() ? "" : line("rivals", "none within 20 : 1");
  }
  for (const Json& r : d["rival_odds"]) {
    const std::string why =
        r["structural"].get<bool>()
            ? "the same data on these points, whatever was measured"
            : fmt::format("{:.2g} : 1 for the named set", r["odds"].get<double>());
    text += line(text.empty() ? "rivals" : "", joined(r["names"], " + ") + ": " + why);
  }
  return text;
}

std::string rms(const Json& value) { return value.is_null() ? "-" : digits(value); }

/// A model's line of the table; `model`: what it is called.
std::string gap_row(const Json& g, const std::string& model) {
  std::string closed;
  if (g.contains("closed_share")) {
    closed = fmt::format("{:.1f} %", 100 * g["closed_share"].get<double>());
    if (g.contains("closed_interval_95")) {
      closed +=
          fmt::format(" (95 %: {:.1f} to {:.1f})", 100 * g["closed_interval_95"][0].get<double>(),
                      100 * g["closed_interval_95"][1].get<double>());
    }
  }
  return fmt::format("{}{:<25} {:>18} {:>18}   {}\n", kIndent, model, rms(g["identify_rms_mm"]),
                     rms(g["validate_rms_mm"]), closed);
}

/// The same of x and of y, where the machine is told of each.
std::string gap_by_axis_text(const Json& d) {
  const char* field =
      d["readings"]["validate"] > 0 ? "validate_rms_by_axis_mm" : "identify_rms_by_axis_mm";
  std::string text;
  for (const char* list : {"gap", "gap_tried"}) {
    for (const Json& g : d.value(list, Json::array())) {
      if (!g.contains(field)) continue;
      text += fmt::format("{}{:<25} {:>18} {:>18}\n", kIndent, g["model"].get<std::string>(),
                          digits(g[field][0]), digits(g[field][1]));
    }
  }
  if (text.empty()) return text;
  return fmt::format("{}{:<25} {:>18} {:>18}\n", kIndent,
                     d["readings"]["validate"] > 0 ? "unseen, of each axis" : "of each axis", "x",
                     "y") +
         text;
}

std::string gap_text(const Json& d) {
  const bool unseen = d["readings"]["validate"] > 0;
  std::string text = line("gap", "rms of measured - simulated per coordinate that is measured, mm");
  text += fmt::format(
      "{}model                     fitted (in-sample)  unseen (held-out)   share of the gap closed "
      "({})\n",
      kIndent, unseen ? "held-out" : "in-sample");
  for (const Json& g : d["gap"]) text += gap_row(g, g["model"].get<std::string>());
  for (const Json& g : d.value("gap_tried", Json::array())) {
    text += gap_row(g, g["model"].get<std::string>() + ", tried");
  }
  return text +
         fmt::format("{}{:<25} {:>18} {:>18}\n", kIndent, "sigma per coordinate",
                     rms(d["noise_floor_mm"]), rms(d["noise_floor_mm"])) +
         gap_by_axis_text(d);
}

std::string audit_text(const Json& d) {
  std::string text =
      line("design", "what these readings can show of each effect, once the geometry is refitted");
  text += fmt::format(
      "{}effect            survives   smallest visible (80 %)   hard to tell from\n", kIndent);
  for (const Json& a : d["audit"]) {
    const Json& smallest = a["smallest_visible"];
    std::string visible = "invisible";
    if (!smallest.is_null()) {
      visible = with_unit(smallest, a["unit"]);
      if (smallest.get<double>() > a["usual_max"].get<double>()) visible += ", unusual";
    }
    std::string last = joined(a["aliases"], ", ");
    if (a.contains("needs")) last = "needs " + a["needs"].get<std::string>();
    text +=
        fmt::format("{}{:<17} {:>7.2f} %   {:<23}   {}\n", kIndent, a["effect"].get<std::string>(),
                    100 * a["surviving_share"].get<double>(), visible, last);
  }
  return text;
}

std::string approach_text(const Json& approach) {
  std::string text;
  for (const Json& a : approach) {
    text += a.get<int>() > 0 ? '+' : a.get<int>() < 0 ? '-' : '0';
  }
  return text;
}

std::string state_text(const Json& state) {
  std::string text;
  if (state.contains("temp_degc")) {
    text += fmt::format(", with the machine at {:.0f} degC", state["temp_degc"].get<double>());
  }
  if (state.contains("wait_h")) {
    text += fmt::format(", {:.0f} h after the last reading", state["wait_h"].get<double>());
  }
  const double approach_mm = state.value("approach_mm", Plan{}.approach_mm);
  if (approach_mm != Plan{}.approach_mm)
    text += fmt::format(", each drive arriving over its last {:g} mm", approach_mm);
  return text;
}

std::string next_text(const Json& d) {
  std::string text;
  std::vector<Json> told;  // each rail has its own entry, with the same words
  for (const Json& u : d["undecided"]) {
    if (std::ranges::find(told, u) != told.end()) continue;
    told.push_back(u);
    text += line(text.empty() ? "undecided" : "",
                 fmt::format("no point within reach {}; measure {}", u["what"].get<std::string>(),
                             u["instead"].get<std::string>()));
  }
  const Json& points = d["next_points"];
  if (points.empty()) return text;
  text += line("next",
               fmt::format("measure {}{} (also as a plan: --plan FILE)",
                           terminal::counted(points.size(), "point"), state_text(d["next_state"])));
  struct Column {
    const char *field, *head;
  };
  std::vector<Column> columns;
  text += kIndent;
  for (const Column& c : {Column{"x_mm", "x mm"}, {"y_mm", "y mm"}, {"phi_deg", "phi deg"}}) {
    if (!points[0].contains(c.field)) continue;
    columns.push_back(c);
    text += fmt::format(" {:>8}", c.head);
  }
  text += "  approach\n";
  std::string why;
  for (const Json& p : points) {
    text += kIndent;
    for (const Column& c : columns) text += fmt::format(" {:>8.1f}", p[c.field].get<double>());
    text += fmt::format("  {:>8}  {}\n", approach_text(p["approach"]),
                        p["why"] == why ? "" : p["why"].get<std::string>());
    why = p["why"];
  }
  return text;
}

std::string argument_text(const Json& d) {
  std::string text = expected_text(d) + far_text(d);
  text += test_text("seen", "what the geometry leaves", d["before"]);
  text += suspects_text(d);
  for (const Json& e : d["effects"]) text += effect_text("named", e);
  if (d.contains("tried")) {
    for (const Json& e : d["tried"]) text += effect_text("tried", e);
  }
  if (d.contains("after")) {
    text += test_text("left",
                      d.contains("tried") ? "what even these effects leave"
                                          : "what geometry and named effects leave",
                      d["after"]);
  }
  text += rivals_text(d) + possible_text(d) + tried_text(d);
  for (std::size_t i = 0; i < d["structure"].size() && i < kPlaces; ++i) {
    const Json& s = d["structure"][i];
    text += line(i == 0 ? "lives" : "",
                 s["where"].get<std::string>() +
                     (s["when"] == "all" ? "" : "; " + s["when"].get<std::string>()));
  }
  return text;
}

}  // namespace

std::string diagnosis_text(const Json& d) {
  std::string text =
      terminal::wrapped(fmt::format("{}: {}", d["verdict"].get<std::string>(), verdict_text(d)));
  if (!d["suspect"].empty()) {
    text += "\n" + suspect_text(d);
  } else {
    text += "\n" + argument_text(d) + "\n" + gap_text(d) + "\n" + audit_text(d);
    const std::string next = next_text(d);
    if (!next.empty()) text += "\n" + next;
  }
  if (!d["notes"].empty()) text += "\n";
  for (const Json& note : d["notes"]) text += line("note", note);
  return text;
}

}  // namespace trammel::job
