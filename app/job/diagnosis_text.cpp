#include "app/job/diagnosis_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace trammel::job {

namespace {

std::string p_text(double p) { return p < 1e-12 ? "p < 1e-12" : fmt::format("p = {:.2g}", p); }

std::string joined(const Json& names, const char* separator) {
  std::string text;
  for (const Json& n : names) text += (text.empty() ? "" : separator) + n.get<std::string>();
  return text;
}

std::string verdict_text(const Json& d) {
  const std::string verdict = d["verdict"];
  std::vector<std::string> names;
  for (const Json& e : d["effects"]) names.push_back(e["name"]);
  const std::string named = joined(Json(names), " + ");
  if (verdict == "nothing_missing") {
    return "nothing is missing that these readings could show (see below what they could not)";
  }
  if (verdict == "explained") return "the gap is explained by " + named;
  if (verdict == "ambiguous")
    return named + " explains the gap, and so does another set: not decided";
  return "there is structure that no effect of the catalogue explains";
}

std::string noise_text(const Json& d) {
  const Json& n = d["noise"];
  std::string text =
      fmt::format("  expected   one reading is known to {:.4f} mm and {:.4f} deg (1 sigma, {})",
                  n["sigma_xy_mm"].get<double>(), n["sigma_phi_deg"].get<double>(),
                  d["noise_source"].get<std::string>());
  if (n["rescaled"].get<bool>()) {
    text += fmt::format(
        "\n             stated were {:.4f} mm and {:.4f} deg: white residuals of another size are "
        "noise, "
        "not structure",
        n["stated_xy_mm"].get<double>(), n["stated_phi_deg"].get<double>());
  }
  if (n["correlation"].get<double>() != 0) {
    text += fmt::format(
        "\n             successive readings are correlated by {:.2f}: taken out before testing",
        n["correlation"].get<double>());
  }
  return text + "\n";
}

std::string test_text(const char* what, const Json& test) {
  const Json& findings = test["findings"];
  std::string text =
      fmt::format("  {:<10} {} tests on the residuals, smallest p corrected for all of them: {}\n",
                  what, test["tests"].get<int>(), p_text(test["family_p"].get<double>()));
  if (test["family_p"].get<double>() > 0.007) return text;
  for (std::size_t i = 0; i < findings.size() && i < 3; ++i) {
    text +=
        fmt::format("             {}; {}: {}\n", findings[i]["where"].get<std::string>(),
                    findings[i]["when"].get<std::string>(), p_text(findings[i]["p"].get<double>()));
  }
  return text;
}

std::string effect_text(const char* what, const Json& e) {
  if (e.contains("seq")) {
    std::string seqs;
    for (const Json& s : e["seq"]) seqs += (seqs.empty() ? "" : ", ") + s.dump();
    return fmt::format(
        "  {:<10} outlier_readings: seq {} (left out of all fits; nothing is deleted)\n", what,
        seqs);
  }
  std::string text =
      fmt::format("  {:<10} {}: {}\n             {:.1f} % of what was explained, {}\n", what,
                  e["name"].get<std::string>(), e["sentence"].get<std::string>(),
                  100 * e["share_of_gap"].get<double>(), p_text(e["p"].get<double>()));
  for (const Json& p : e["parameters"]) {
    text +=
        fmt::format("             {:<5} = {:>12.5g} +- {:.2g} {} (1 sigma){}\n",
                    p["name"].get<std::string>(), p["value"].get<double>(), p["std"].get<double>(),
                    p["unit"] == "1" ? "" : p["unit"].get<std::string>(),
                    p.contains("unusual") ? "  unusual: outside its usual range" : "");
  }
  return text;
}

std::string rivals_text(const Json& d) {
  std::string text;
  if (!d.contains("rival_odds")) return text;
  for (const Json& r : d["rival_odds"]) {
    const std::string why =
        r["structural"].get<bool>()
            ? "the same data on these points, whatever was measured"
            : fmt::format("{:.2g} : 1 for the named set", r["odds"].get<double>());
    text += fmt::format("  rival      {}: {}\n", joined(r["names"], " + "), why);
  }
  return text;
}

std::string rms(const Json& value) {
  return value.is_null() ? "-" : fmt::format("{:.4f}", value.get<double>());
}

std::string gap_text(const Json& d) {
  std::string text =
      "  gap        rms of measured - simulated per coordinate, mm\n"
      "             model                     fitted (in-sample)  unseen (held-out)   share of the "
      "gap closed\n";
  for (const Json& g : d["gap"]) {
    std::string closed;
    if (g.contains("closed_share")) {
      closed = fmt::format("{:.1f} %", 100 * g["closed_share"].get<double>());
      if (g.contains("closed_interval_95")) {
        closed +=
            fmt::format(" (95 %: {:.1f} to {:.1f})", 100 * g["closed_interval_95"][0].get<double>(),
                        100 * g["closed_interval_95"][1].get<double>());
      }
    }
    text += fmt::format("             {:<25} {:>18} {:>18}   {}\n", g["model"].get<std::string>(),
                        rms(g["identify_rms_mm"]), rms(g["validate_rms_mm"]), closed);
  }
  return text + fmt::format("             {:<25} {:>18} {:>18}\n", "noise floor",
                            rms(d["noise_floor_mm"]), rms(d["noise_floor_mm"]));
}

std::string audit_text(const Json& d) {
  std::string text =
      "  design     what these readings can show of each effect, once the geometry is refitted\n"
      "             effect            survives   smallest visible (80 %)   hard to tell from\n";
  for (const Json& a : d["audit"]) {
    std::string visible = "invisible";
    if (!a["smallest_visible"].is_null() && a["surviving_share"].get<double>() > 1e-4) {
      visible = fmt::format("{:.2g} {}", a["smallest_visible"].get<double>(),
                            a["unit"] == "1" ? "" : a["unit"].get<std::string>());
    }
    std::string last = joined(a["aliases"], ", ");
    if (a.contains("needs")) last = "needs " + a["needs"].get<std::string>();
    text += fmt::format("             {:<17} {:>7.2f} %   {:<23}   {}\n",
                        a["effect"].get<std::string>(), 100 * a["surviving_share"].get<double>(),
                        visible, last);
  }
  return text;
}

std::string approach_text(const Json& approach) {
  std::string text;
  for (const Json& a : approach) text += a.get<int>() > 0 ? '+' : '-';
  return text;
}

std::string next_text(const Json& d) {
  std::string text;
  for (const Json& u : d["undecided"]) {
    const std::string what = u;
    text += "  undecided  no point within reach " + what;
    if (what.find("tracker_scale") != std::string::npos)
      text += ": measure a reference length (scale bar)";
    text += "\n";
  }
  if (d["next_points"].empty()) return text;
  text += fmt::format("  next       {} points would decide (also as a plan: --plan FILE)\n",
                      d["next_points"].size());
  text += "                  x mm     y mm  phi deg  approach  why\n";
  for (const Json& p : d["next_points"]) {
    text +=
        fmt::format("             {:>9.1f} {:>8.1f} {:>8.1f}  {:>8}  {}\n", p["x_mm"].get<double>(),
                    p["y_mm"].get<double>(), p["phi_deg"].get<double>(),
                    approach_text(p["approach"]), p["why"].get<std::string>());
  }
  return text;
}

}  // namespace

std::string diagnosis_text(const Json& d) {
  std::string text = fmt::format("{}: {}\n\n", d["verdict"].get<std::string>(), verdict_text(d));
  text += noise_text(d);
  text += test_text("seen", d["before"]);
  for (const Json& e : d["effects"]) text += effect_text("named", e);
  text += rivals_text(d);
  if (d.contains("after")) text += test_text("left", d["after"]);
  if (d.contains("tried")) {
    for (const Json& e : d["tried"]) text += effect_text("tried", e);
  }
  for (std::size_t i = 0; i < d["structure"].size() && i < 3; ++i) {
    const Json& s = d["structure"][i];
    text += fmt::format("  lives      {}; {}\n", s["where"].get<std::string>(),
                        s["when"].get<std::string>());
  }
  text += "\n" + gap_text(d) + "\n" + audit_text(d) + "\n" + next_text(d);
  for (const Json& note : d["notes"]) text += "  note       " + note.get<std::string>() + "\n";
  return text;
}

}  // namespace trammel::job
