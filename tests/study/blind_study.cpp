// Counts how often the diagnosis is right, silent or wrong, on campaigns that nobody tuned to.
//   trammel_blind_study [--cases N] [--seed S] [--only NAME]… [--verbose] [--demand] [--next]
// Prints one row per kind of campaign, then what all of them say together; scripts/blind_study
// builds and runs it, and a small one is among the tests.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "core/diagnose/diagnose.hpp"
#include "core/statistics/random.hpp"
#include "tests/study/campaigns.hpp"
#include "tests/study/foreign.hpp"
#include "tests/study/judge.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

struct Kind {
  std::string name;
  Design design;
  std::vector<std::string> hidden;
  double rho = 0;
  bool mixed = false;  // design, effects and size are drawn for every campaign
  std::optional<ForeignDesign> foreign = {};
  std::size_t effects = 0;  // of the catalogue, which and of what size by chance
};

std::vector<Kind> clean_kinds() {
  return {{"clean", {}, {}},
          {"clean, paper-80", {.name = "paper"}, {}},
          {"clean, 2 epochs", {.epochs = 2}, {}},
          {"clean, 3 epochs", {.epochs = 3}, {}},
          {"clean, sigma +30 %", {.stated_over_true = 1.3}, {}},
          {"clean, sigma -30 %", {.stated_over_true = 0.7}, {}},
          {"clean, 100 points", {.thinning = 0.36}, {}},
          {"clean, one direction", {.one_direction = true}, {}},
          {"clean, correlated 0.3", {.correlation = 0.3}, {}},
          {"clean, correlated 0.6", {.correlation = 0.6}, {}},
          {"clean, correlated -0.2", {.correlation = -0.2}, {}},
          {"clean, correlated -0.5", {.correlation = -0.5}, {}},
          {"clean, Student t3", {.student = 3}, {}},
          {"clean, Student t5", {.student = 5}, {}},
          {"clean, 40 points", {.thinning = 0.145}, {}},
          {"clean, 20 points", {.thinning = 0.075}, {}}};
}

/// What a case is made of: "backlash rho 14, 2 epochs".
Kind hidden_kind(const std::vector<std::string>& hidden, double rho, const std::string& how = "",
                 const Design& design = {}) {
  std::string name;
  for (const auto& h : hidden) name += (name.empty() ? "" : "+") + h;
  char text[96];
  std::snprintf(text, sizeof text, "%s rho %.0f%s%s", name.c_str(), rho, how.empty() ? "" : ", ",
                how.c_str());
  return {text, design, hidden, rho};
}

/// Beyond it an effect would be larger than instruments make it.
double largest_rho(const std::string& family) { return family == "tracker_scale" ? 9 : 1000; }

/// Machines that are no 3-PRR, with what can be large on them: "3-PPR, clean", "XY, backlash rho
/// 14".
std::vector<Kind> kinds_of_machines() {
  const std::vector<std::pair<std::string, std::vector<std::string>>> machines = {
      {"3-PPR",
       {"lead_scale", "screw_periodic", "backlash", "guide_yaw", "tracker_drift", "setup_shift",
        "belt_period"}},
      {"3-RPR",
       {"lead_scale", "lead_curvature", "screw_periodic", "backlash", "thermal_growth",
        "tracker_drift", "setup_shift", "cubic_lead"}},
      {"XY", {"lead_scale",  "lead_curvature", "screw_periodic", "backlash",      "thermal_growth",
              "guide_bow",   "guide_yaw",      "tracker_drift",  "tracker_scale", "setup_shift",
              "cubic_lead",  "rail_bump",      "half_turn",      "belt_period",   "start_transient",
              "lost_motion", "thermal_lag",    "hysteresis",     "move_memory",   "overshoot"}},
      {"X",
       {"lead_scale", "lead_curvature", "screw_periodic", "backlash", "thermal_growth",
        "tracker_drift", "tracker_scale", "setup_shift", "cubic_lead", "rail_bump", "half_turn",
        "belt_period", "start_transient", "lost_motion", "thermal_lag", "hysteresis", "move_memory",
        "overshoot"}}};
  std::vector<Kind> all;
  for (const auto& [machine, hidden] : machines) {
    const Design usual = design_of(machine);
    all.push_back({machine + ", clean", usual, {}});
    if (find_machine_kind(machine)->has_point_platform()) {
      const auto clean = [&](const char* how, void (*change)(Design&)) {
        Design design = usual;
        change(design);
        all.push_back({machine + ", clean, " + how, design, {}});
      };
      clean("2 epochs", [](Design& d) { d.epochs = 2; });
      clean("one direction", [](Design& d) { d.one_direction = true; });
      clean("sigma +30 %", [](Design& d) { d.stated_over_true = 1.3; });
      clean("sigma -30 %", [](Design& d) { d.stated_over_true = 0.7; });
      clean("correlated 0.3", [](Design& d) { d.correlation = 0.3; });
      clean("Student t5", [](Design& d) { d.student = 5; });
      clean("30 points", [](Design& d) { d.thinning = 0.2; });
    }
    for (const double rho : {14.0, 28.0}) {
      for (const std::string& name : hidden) {
        all.push_back(hidden_kind({name}, rho, "", design_of(machine)));
        all.back().name = machine + ", " + all.back().name;
      }
    }
  }
  return all;
}

std::vector<Kind> kinds() {
  std::vector<Kind> all = clean_kinds();
  for (const Family& f : families()) {
    if (f.name == "guide_yaw") continue;  // none on a PRR
    for (const double rho : {4.0, 6.0, 9.0, 14.0, 28.0}) {
      if (rho > largest_rho(f.name)) continue;
      all.push_back(hidden_kind({f.name}, rho));
    }
  }
  for (const std::vector<std::string>& set : {std::vector<std::string>{"backlash", "lead_scale"},
                                              {"screw_periodic", "thermal_growth"},
                                              {"guide_bow", "tracker_drift"},
                                              {"backlash", "guide_bow"},
                                              {"backlash", "lead_scale", "screw_periodic"},
                                              {"backlash", "lead_scale", "platform_load"},
                                              {"lead_scale", "platform_load"},
                                              {"backlash", "guide_bow", "thermal_growth"},
                                              {"lead_curvature", "screw_periodic", "tracker_drift"},
                                              {"axis_crosstalk", "backlash", "lead_curvature"},
                                              {"lead_scale", "move_memory"},
                                              {"guide_bow", "lagged_growth"}}) {
    all.push_back(hidden_kind(set, 20));
    all.push_back(hidden_kind(set, 20, "2 epochs", {.epochs = 2}));
  }
  for (const char* f : {"backlash", "lead_curvature", "screw_periodic"}) {
    all.push_back(hidden_kind({f}, 14, "sigma +30 %", {.stated_over_true = 1.3}));
    all.push_back(hidden_kind({f}, 14, "sigma -30 %", {.stated_over_true = 0.7}));
    all.push_back(hidden_kind({f}, 14, "correlated 0.4", {.correlation = 0.4}));
    all.push_back(hidden_kind({f}, 14, "Student t3", {.student = 3}));
    all.push_back(hidden_kind({f}, 14, "100 points", {.thinning = 0.36}));
    all.push_back(hidden_kind({f}, 14, "3 epochs", {.epochs = 3}));
  }
  for (const double rho : {14.0, 28.0}) {
    all.push_back(hidden_kind({"screw_periodic"}, rho, "lead 1 % wrong", {.lead_error = 0.01}));
  }
  all.push_back(hidden_kind({"lead_scale"}, 300));
  all.push_back(hidden_kind({"backlash", "lead_scale"}, 300));
  for (const double size : {1e-4, 5e-4, 2e-3, 5e-3}) {
    for (const bool turns : {true, false}) {
      char text[64];
      std::snprintf(text, sizeof text, "foreign stage, %g%s", size, turns ? ", turning" : "");
      all.push_back({text, {}, {}});
      all.back().foreign = ForeignDesign{.size = size, .turns = turns, .yaws = turns};
    }
  }
  for (const Kind& kind : kinds_of_machines()) all.push_back(kind);
  all.push_back({"outliers", {.outliers = 4}, {}});
  all.push_back({"mixed", {}, {}, 0, true});
  for (const std::size_t n : {1U, 2U, 3U}) {
    all.push_back({std::to_string(n) + " of the catalogue", {}, {}, 0, true});
    all.back().effects = n;
  }
  return all;
}

/// Effects of the catalogue that nobody chose, on the rich design.
Kind draw(std::size_t effects, std::uint64_t seed) {
  constexpr std::uint64_t kKnown = 9;  // the first families but tracker_scale
  Random random = Random::stream(seed, "effects");
  Kind k;
  k.rho = std::exp(random.uniform(std::log(9), std::log(28)));
  while (k.hidden.size() < effects) {
    const std::string& name = families()[random.below(kKnown)].name;
    if (std::ranges::find(k.hidden, name) == k.hidden.end()) k.hidden.push_back(name);
  }
  return k;
}

/// A campaign nobody chose: design, effects and their size by chance.
Kind draw(std::uint64_t seed) {
  Random random = Random::stream(seed, "mixed");
  Kind k;
  k.design.epochs = 1 + static_cast<int>(random.below(3));
  k.design.thinning = random.uniform() < 0.3 ? random.uniform(0.4, 1) : 1;
  k.design.sigma_xy_mm = random.uniform() < 0.3 ? random.uniform(0.004, 0.025) : 0.010;
  k.design.sigma_phi_deg = k.design.sigma_xy_mm * random.uniform(0.3, 0.6);
  k.design.stated_over_true = random.uniform() < 0.3 ? random.uniform(0.7, 1.3) : 1;
  k.design.lead_mm = random.uniform() < 0.3 ? random.uniform(4, 16) : 10;
  k.design.correlation = random.uniform() < 0.2 ? random.uniform(0.2, 0.5) : 0;
  if (random.uniform() < 0.15) {
    k.design.name = "paper";
    k.design.epochs = 1;  // its unseen points come last
  }
  const double what = random.uniform();
  if (what < 0.15) return k;
  if (what < 0.22) {
    k.design.outliers = 2 + static_cast<int>(random.below(4));
    return k;
  }
  k.rho = std::exp(random.uniform(std::log(9), std::log(28)));
  const std::uint64_t known = 10;  // of the families are a 3-PRR's: the first ones, then guide_yaw
  if (what < 0.4) {
    const std::uint64_t outside = known + 1;
    k.hidden = {families()[outside + random.below(families().size() - outside)].name};
    return k;
  }
  const auto first = random.below(known);
  k.hidden = {families()[first].name};
  if (k.hidden.front() == "tracker_scale") {
    k.rho = largest_rho(k.hidden.front());
    k.design = {.epochs = k.design.epochs};
  } else if (what > 0.75 && k.design.name != "paper") {
    const auto second =
        (first + 1 + random.below(known - 2)) % (known - 1);  // tracker_scale is last
    k.hidden.push_back(families()[second].name);
  }
  return k;
}

std::string in_words(const Kind& k) {
  const Design& d = k.design;
  char text[192];
  std::snprintf(
      text, sizeof text,
      "%s, rho %.0f, epochs %d, sigma %.1f um and %.4f deg, stated %.2f of it, lead %.1f, "
      "correlated %.2f, thinned %.2f, outliers %d",
      d.name.c_str(), k.rho, d.epochs, 1000 * d.sigma_xy_mm, d.sigma_phi_deg, d.stated_over_true,
      d.lead_mm, d.correlation, d.thinning, d.outliers);
  return text;
}

HiddenCase make(const Kind& kind, std::uint64_t seed) {
  if (kind.foreign) return make_foreign(*kind.foreign, seed);
  std::vector<const Family*> hidden;
  for (const auto& name : kind.hidden) hidden.push_back(&family(name));
  return make_case(kind.design, hidden, kind.rho, seed);
}

void print_row(const std::string& name, const Tally& t) {
  std::printf("%-46s %5d %5d %5d %5d %6d %5d | %5d %5d %5d | %4d/%-4d %4d/%-4d %4d/%-4d\n",
              name.c_str(), t.cases, t.named, t.ambiguous, t.silent, t.unexplained, t.wrong,
              t.right, t.abstained, t.cases - t.right - t.abstained, t.values_good, t.values,
              t.closed, t.explained, t.covered, t.counted);
}

/// Upper end of the 95 % interval (one-sided) of a rate of which `k` of `n` were seen.
double upper_95(int k, int n) {
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double p = 0.5 * (low + high);
    double term = std::pow(1 - p, n), sum = term;
    for (int j = 0; j < k; ++j) sum += term *= (n - j) / (j + 1.0) * p / (1 - p);
    (sum > 0.05 ? low : high) = p;
  }
  return low;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"How often the diagnosis is right, silent or wrong"};
  int cases = 20, first = 0, threads = 2;
  std::uint64_t seed = 1;
  std::vector<std::string> only, but;
  bool verbose = false, demand = false, next = false;
  app.add_option("--cases", cases, "campaigns of each kind");
  app.add_option("--seed", seed, "of the first campaign");
  app.add_option("--only", only, "kinds whose name contains this, or one of these");
  app.add_option("--but", but, "leave out kinds whose name contains this");
  app.add_option("--threads", threads, "campaigns at a time");
  app.add_option("--first", first, "number of the first campaign of each kind (0)");
  app.add_flag("--verbose", verbose, "a line for each answer that was given");
  app.add_flag("--demand", demand, "fail (exit code 1) when an answer is wrong");
  app.add_flag("--next", next, "measure the points that ambiguous answers ask for, and ask again");
  CLI11_PARSE(app, argc, argv);
  const auto asked = [&](const Kind& kind) {
    const auto has = [&](const std::string& part) {
      return kind.name.find(part) != std::string::npos;
    };
    return (only.empty() || std::any_of(only.begin(), only.end(), has)) &&
           std::none_of(but.begin(), but.end(), has);
  };
  std::printf("%-46s %5s %5s %5s %5s %6s %5s | %5s %5s %5s | %9s %9s %9s\n", "kind", "cases",
              "named", "ambig", "silent", "unexpl", "WRONG", "right", "abst.", "wrong", "values",
              "closed", "in 2 std");
  Tally clean, all;
  for (const Kind& kind : kinds()) {
    if (!asked(kind)) continue;
    Tally tally;
    std::map<std::string, int> said;
    int alarms = 0;  // of the base
    double furthest = 0;
    Round round;
    std::mutex mutex;
    std::atomic<int> turn{first};
    const auto work = [&] {
      for (int i = turn++; i < first + cases; i = turn++) {
        const std::uint64_t own = mix(seed, kind.name, static_cast<std::uint64_t>(i));
        const Kind drawn = kind.effects > 0 ? draw(kind.effects, own)
                           : kind.mixed     ? draw(own)
                                            : kind;
        const HiddenCase c = make(drawn, own);
        DiagnoseOptions options;
        options.threads = 1;
        const Diagnosis d = diagnose(c.campaign, options);
        const Judgement judged = judge(c, d);
        Round then;
        if (next && d.verdict == Verdict::ambiguous && !d.next.points.empty()) {
          then = judge_round(c, d, diagnose(with_points(c, d.next), options));
        }
        const std::lock_guard lock(mutex);
        alarms += d.base.implausible();
        round.ties += then.ties;
        round.decided += then.decided;
        round.asked += then.asked;
        round.kept += then.kept;
        furthest = std::max(furthest, d.base.tolerances);
        tally.add(judged);
        ++said[(judged.right() ? "  " : "! ") + in_words(c, d, judged) +
               (kind.mixed ? " (campaign " + std::to_string(i) + ": " + in_words(drawn) + ")"
                           : "")];
      }
    };
    std::vector<std::thread> pool;
    for (int t = 1; t < threads; ++t) pool.emplace_back(work);
    work();
    for (auto& t : pool) t.join();
    print_row(kind.name, tally);
    std::printf("      base implausible in %d, at most %.1f tolerances off\n", alarms, furthest);
    if (next)
      std::printf(
          "      one round decides %d of %d ties; what was hidden is among the sets left in %d of "
          "%d\n",
          round.decided, round.ties, round.kept, round.asked);
    if (kind.name.find("clean") != std::string::npos) clean.add(tally);
    all.add(tally);
    if (verbose) {
      for (const auto& [line, n] : said) std::printf("      %3d x %s\n", n, line.c_str());
    }
    std::fflush(stdout);
  }
  print_row("all", all);
  if (clean.cases > 0) {
    const int alarms = clean.cases - clean.right;
    std::printf("false alarms: %d of %d clean campaigns, %.2f %%, below %.2f %% (95 %%)\n", alarms,
                clean.cases, 100.0 * alarms / clean.cases, 100 * upper_95(alarms, clean.cases));
  }
  return demand && (all.cases == 0 || all.right + all.abstained < all.cases) ? 1 : 0;
}
