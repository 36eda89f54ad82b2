// Counts how often the diagnosis is right, silent or wrong, on campaigns that nobody tuned to.
//   trammel_blind_study [--cases N] [--seed S] [--only NAME] [--verbose]
// Prints one row per kind of campaign; scripts/blind_study builds and runs it.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <map>
#include <mutex>
#include <thread>

#include "core/diagnose/diagnose.hpp"
#include "core/random.hpp"
#include "tests/study/campaigns.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

struct Kind {
  std::string name;
  Design design;
  std::vector<std::string> hidden;
  double rho = 0;
};

struct Tally {
  int cases = 0, right = 0, ambiguous = 0, silent = 0, unexplained = 0, wrong = 0, failed = 0;
};

std::vector<Kind> kinds() {
  std::vector<Kind> all = {{"clean", {}, {}, 0},
                           {"clean, paper-80", {.name = "paper"}, {}, 0},
                           {"clean, 2 epochs", {.epochs = 2}, {}, 0},
                           {"clean, 3 epochs", {.epochs = 3}, {}, 0},
                           {"clean, sigma +30 %", {.stated_over_true = 1.3}, {}, 0},
                           {"clean, sigma -30 %", {.stated_over_true = 0.7}, {}, 0},
                           {"clean, 100 points", {.thinning = 0.36}, {}, 0},
                           {"clean, correlated 0.3", {.correlation = 0.3}, {}, 0},
                           {"clean, correlated 0.6", {.correlation = 0.6}, {}, 0}};
  for (const Family& f : families()) {
    for (const double rho : {4.0, 6.0, 9.0, 14.0, 28.0}) {
      char name[64];
      std::snprintf(name, sizeof name, "%s rho %.0f", f.name.c_str(), rho);
      all.push_back({name, {}, {f.name}, rho});
    }
  }
  const std::vector<std::vector<std::string>> sets = {{"backlash", "lead_scale"},
                                                      {"screw_periodic", "thermal_growth"},
                                                      {"guide_bow", "tracker_drift"},
                                                      {"backlash", "guide_bow"},
                                                      {"backlash", "lead_scale", "screw_periodic"}};
  for (const auto& set : sets) {
    std::string name = set[0];
    for (std::size_t i = 1; i < set.size(); ++i) name += "+" + set[i];
    all.push_back({name + " rho 20", {}, set, 20});
    all.push_back({name + " rho 20, 2 epochs", {.epochs = 2}, set, 20});
  }
  for (const char* f : {"backlash", "lead_curvature", "screw_periodic"}) {
    all.push_back({std::string(f) + " rho 14, sigma +30 %", {.stated_over_true = 1.3}, {f}, 14});
    all.push_back({std::string(f) + " rho 14, sigma -30 %", {.stated_over_true = 0.7}, {f}, 14});
    all.push_back({std::string(f) + " rho 14, correlated 0.4", {.correlation = 0.4}, {f}, 14});
    all.push_back({std::string(f) + " rho 14, 100 points", {.thinning = 0.36}, {f}, 14});
  }
  all.push_back(
      {"screw_periodic rho 14, lead 1 % wrong", {.lead_error = 0.01}, {"screw_periodic"}, 14});
  all.push_back(
      {"screw_periodic rho 28, lead 1 % wrong", {.lead_error = 0.01}, {"screw_periodic"}, 28});
  return all;
}

std::vector<std::string> named(const Diagnosis& d) {
  std::vector<std::string> names;
  for (const auto& e : d.effects) names.push_back(e.name);
  std::sort(names.begin(), names.end());
  return names;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& n : names) text += (text.empty() ? "" : "+") + n;
  return text.empty() ? "-" : text;
}

void count(Tally& tally, const HiddenCase& c, const Diagnosis& d) {
  ++tally.cases;
  switch (d.verdict) {
    case Verdict::nothing_missing:
      c.hidden.empty() ? ++tally.right : ++tally.silent;
      break;
    case Verdict::unexplained:
      ++tally.unexplained;
      break;
    case Verdict::ambiguous:
      ++tally.ambiguous;
      break;
    case Verdict::explained:
      named(d) == c.hidden ? ++tally.right : ++tally.wrong;
      break;
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"How often the diagnosis is right, silent or wrong"};
  int cases = 20, threads = 2;
  std::uint64_t seed = 1;
  std::string only;
  bool verbose = false;
  app.add_option("--cases", cases, "campaigns of each kind");
  app.add_option("--seed", seed, "of the first campaign");
  app.add_option("--only", only, "kinds whose name contains this");
  app.add_option("--threads", threads, "campaigns at a time");
  app.add_flag("--verbose", verbose, "a line for each that is not right");
  CLI11_PARSE(app, argc, argv);
  std::printf("%-52s %6s %6s %6s %6s %6s %6s\n", "kind", "cases", "right", "ambig", "silent",
              "unexpl", "WRONG");
  for (const Kind& kind : kinds()) {
    if (kind.name.find(only) == std::string::npos) continue;
    Tally tally;
    std::map<std::string, int> said;
    std::mutex mutex;
    std::atomic<int> next{0};
    const auto work = [&] {
      for (int i = next++; i < cases; i = next++) {
        std::vector<const Family*> hidden;
        for (const auto& name : kind.hidden) hidden.push_back(&family(name));
        const HiddenCase c = make_case(kind.design, hidden, kind.rho,
                                       mix(seed, kind.name, static_cast<std::uint64_t>(i)));
        DiagnoseOptions options;
        options.threads = 1;
        const Diagnosis d = diagnose(c.campaign, options);
        const std::lock_guard lock(mutex);
        count(tally, c, d);
        std::string line = to_string(d.verdict) + " " + joined(named(d));
        for (const Rival& r : d.rivals) line += " | " + joined(r.names);
        if (d.verdict == Verdict::unexplained && !d.structure.empty())
          line += " @ " + d.structure[0].where + ", " + d.structure[0].when;
        ++said[line];
      }
    };
    std::vector<std::thread> pool;
    for (int t = 1; t < threads; ++t) pool.emplace_back(work);
    work();
    for (auto& t : pool) t.join();
    std::printf("%-52s %6d %6d %6d %6d %6d %6d\n", kind.name.c_str(), tally.cases, tally.right,
                tally.ambiguous, tally.silent, tally.unexplained, tally.wrong);
    if (verbose) {
      for (const auto& [line, n] : said) std::printf("      %3d x %s\n", n, line.c_str());
    }
    std::fflush(stdout);
  }
}
