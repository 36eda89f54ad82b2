// The figures on the safety of data, measured: scripts/stress. The small version is
// the tests of this folder.

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "store/job.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/stress/bench.hpp"
#include "tests/stress/byte_sweep.hpp"
#include "tests/stress/faults.hpp"
#include "tests/stress/kills.hpp"
#include "tests/stress/mutate.hpp"
#include "tests/stress/power_loss.hpp"
#include "tests/stress/soak.hpp"

namespace trammel::test {

namespace {

constexpr std::uint64_t kSeed = 20240501;
int n_missed = 0;
int n_bench_runs = 0;

void row(const std::string& figure, const std::string& demand, const std::string& measured,
         bool reached, const std::string& problem = "") {
  fmt::print("| {} | {} | {} | {} |\n", figure, demand, measured, reached ? "reached" : "MISSED");
  if (!reached && !problem.empty()) fmt::print(stderr, "{}: {}\n", figure, problem);
  std::fflush(stdout);
  n_missed += reached ? 0 : 1;
}

void power_rows(const TempFolder& folder, bool whole) {
  const auto text = [](const PowerLossCount& c) {
    return fmt::format(
        "{} images of {} operations, {} of them written back under acknowledged points: {} with a "
        "loss (up to {} points), {} corrupt; {} sessions finished from one, {} wrong",
        c.images, c.operations, c.written_back, c.lost_images, c.lost_points, c.corrupt, c.resumed,
        c.wrong_resumes);
  };
  const auto run = [&folder](PowerLossOptions options) {
    std::filesystem::remove_all(folder.file("power"));
    std::filesystem::create_directory(folder.file("power"));
    return lose_power(folder.file("power"), options);
  };
  const int least = whole ? 10'000 : 1'000;
  const auto holds = [&](const char* what, const PowerLossOptions& options, int images) {
    const PowerLossCount c = run(options);
    row(fmt::format("power loss: {}", what), fmt::format(">= {} images, 0 lost, 0 corrupt", images),
        text(c), c.images >= images && c.lost_images + c.corrupt + c.wrong_resumes == 0,
        c.first_problem);
  };
  const auto fails = [&](const char* what, const PowerLossOptions& options, bool corrupts) {
    const PowerLossCount c = run(options);
    row(fmt::format("control: {}", what), corrupts ? "must corrupt" : "must lose", text(c),
        (corrupts ? c.corrupt : c.lost_images) > 0);
  };
  const int every = whole ? 1 : 5;
  holds("dropped, torn at sectors of 512 and 4096 bytes, reordered within and across files",
        {.record = {.n_points = 60}, .every = every}, least);
  holds("the same, the log written back every 20 pages",
        {.record = {.n_points = whole ? 80 : 30, .checkpoint_pages = 20}, .every = every}, least);
  holds("while a reading is kept aside on a full disk",
        {.record = {.n_points = 6, .full_after = 3}, .from_told = 2, .resume_every = 50}, 200);
  const RecordOptions few{.n_points = 20, .checkpoint_pages = 20};
  RecordOptions off = few;
  off.durability = Durability::off;
  const auto control = [](const RecordOptions& record, Lie lie) {
    return PowerLossOptions{.record = record, .every = 5, .resume_every = 0, .lie = lie};
  };
  fails("synchronous=NORMAL", control({.n_points = 20, .durability = Durability::normal}, {}),
        false);
  fails("a disk that lies about sync", control({.n_points = 20}, Lie::sync), false);
  fails("a folder that is not synced", control({.n_points = 20}, Lie::names), false);
  fails("synchronous=OFF, the log written back every 20 pages", control(off, {}), true);
}

void bench_rows(const std::vector<BenchRow>& rows) {
  for (const BenchRow& r : rows) {
    std::string judged;
    if (r.falsehoods) judged += fmt::format("{} false left valid, ", *r.falsehoods);
    if (r.lost) judged += fmt::format("{} lost, ", *r.lost);
    std::string measured =
        fmt::format("{} runs from seed {}, {} done, {} readings stored: {}{} {}", r.runs, kSeed,
                    r.done, r.readings, judged, r.wrong, r.control ? "as demanded" : "violations");
    n_bench_runs += r.control ? 0 : r.runs;
    if (r.worst_s > 0) measured += fmt::format(", stop command after {:.3f} s at most", r.worst_s);
    row(r.figure, r.demand, measured, r.reached(), r.first_problem);
  }
}

void fault_rows(const TempFolder& folder, bool whole) {
  struct Case {
    const char* name;
    Fault fault;
  };
  for (const Case& c : {Case{"I/O error", Fault::io_error}, Case{"disk full", Fault::disk_full},
                        Case{"out of memory", Fault::out_of_memory}}) {
    for (const bool for_good : {false, true}) {
      const std::int64_t every = c.fault == Fault::out_of_memory ? (whole ? 3 : 401)
                                 : whole                         ? 1
                                                                 : 9;
      const FaultCount n =
          sweep_faults(folder.path(), {.fault = c.fault, .for_good = for_good, .every = every});
      row(fmt::format("{}, {}", c.name, for_good ? "for good from the n-th" : "at the n-th, once"),
          for_good ? "0 violations, always reported" : "0 violations",
          fmt::format("{} runs, n = 1{} to {}: {} reported; {} lost, {} corrupt, {} unfinished, {} "
                      "unreported",
                      n.runs, every == 1 ? "" : fmt::format(", {}, …", 1 + every), n.operations,
                      n.reported, n.lost, n.corrupt, n.unfinished, n.unreported),
          n.violations() == 0 && n.runs > 0, n.first_problem);
    }
  }
  const FaultCount careless =
      sweep_faults(folder.path(),
                   {.fault = Fault::disk_full, .for_good = true, .recorder = careless_recorder()});
  row("control: a recorder that looks at no answer", "must lose, and not report",
      fmt::format("{} runs: {} lost, {} unreported", careless.runs, careless.lost,
                  careless.unreported),
      careless.lost > 0 && careless.unreported > 0);
}

void kill_row(const TempFolder& folder, int kills) {
  const KillCount c = sweep_kills(folder.path(), {.kills = kills});
  row("kill -9 at random times of a simulated campaign",
      "0 acknowledged readings lost, none repeated, each bit as undisturbed",
      fmt::format("{} kills of {} campaigns ({} after an acknowledged point): {} lost, {} corrupt, "
                  "{} repeated, {} with other bits",
                  c.kills, c.campaigns, c.with_points, c.lost, c.corrupt, c.repeated, c.different),
      c.kills >= kills && c.lost + c.corrupt + c.repeated + c.different == 0, c.first_problem);
  const TempFolder apart;
  const KillCount torn = sweep_kills(apart.path(), {.kills = 50, .loses_log = true});
  row("control: a log that does not outlive the kill", "must lose",
      torn.lost > 0 ? torn.first_problem : fmt::format("0 lost in {} kills", torn.kills),
      torn.lost > 0);
}

void socket_kill_row(const TempFolder& folder, int points, int kills) {
  const KillCount c = sweep_socket_kills(folder.path(), points, kills);
  row("kill -9 at random times of one campaign over sockets, to its end",
      "0 acknowledged readings lost, none repeated, each where the robot was",
      fmt::format("{} points, {} kills ({} after an acknowledged point): {} lost, {} corrupt, {} "
                  "repeated, {} elsewhere",
                  c.points, c.kills, c.with_points, c.lost, c.corrupt, c.repeated, c.different),
      c.points == points && c.kills >= std::min(kills, 3) &&
          c.lost + c.corrupt + c.repeated + c.different == 0,
      c.first_problem);
}

void verify_row(const TempFolder& folder, bool whole) {
  const auto file = folder.file("verify.db"), copy = folder.file("verify-copy.db");
  {
    store::Connection db = store::open(file, store::Access::create);
    const store::Id campaign =
        store::import_campaign(db, small_campaign(), {.extra_json = {{2, "{}"}}}).campaign_id;
    store::add_event(db, measured_session(db, campaign, "baseline", 12), "done");
    store::exclude_reading(db, campaign, 2, "bumped");
  }
  store::Connection(file, store::Access::write).execute("VACUUM INTO '" + copy.string() + "'");
  SweepCount all{.untouched_is_clean = true};
  for (const char* table :
       {"reading", "point", "attempt", "epoch", "session", "campaign", "machine_chain", "drive",
        "campaign_fact", "exclusion", "session_event"}) {
    const SweepCount c =
        sweep_bytes(copy, {.table = table, .masks = {0x01, 0x80, 0xFF}, .step = whole ? 1 : 5});
    all.rows += c.rows;
    all.bytes += c.bytes;
    all.found += c.found;
    all.named += c.named;
    all.untouched_is_clean = all.untouched_is_clean && c.untouched_is_clean;
    if (all.first_miss.empty()) all.first_miss = c.first_miss;
  }
  row("db verify: single changed bytes in raw rows", "all found, the row named",
      fmt::format("{} changes of {} rows of 11 tables: {} found, {} named", all.bytes, all.rows,
                  all.found, all.named),
      all.untouched_is_clean && all.found == all.bytes && all.named == all.bytes, all.first_miss);
  const SweepCount plain = sweep_bytes(copy, {.look = store::check});
  row("control: SQLite's own integrity_check", "must miss some",
      fmt::format("{} changes of {} readings: {} found", plain.bytes, plain.rows, plain.found),
      plain.found < plain.bytes);
}

void wire_rows(bool whole) {
  for (const auto kind : {emulate::FaultKind::lost_reply, emulate::FaultKind::half_reply,
                          emulate::FaultKind::dropped}) {
    const WireCount c = sweep_wires(kind, whole ? 1 : 7);
    row(fmt::format("{} at each line of a campaign over sockets", emulate::name_of(kind)),
        "each point stored once and as it was",
        fmt::format("{} campaigns of 4 points, {} resumed: {} wrong", c.runs, c.resumed, c.wrong),
        c.runs > (whole ? 100 : 15) && c.wrong == 0, c.first_problem);
  }
}

void soak_row(int points) {
  const SoakCount c = soak_over_sockets({.n_points = points});
  row("soak over sockets: emulators, drivers, runner, random faults, stops and deaths",
      "0 acknowledged lost, 0 repeated or invalid, parameters as without faults",
      fmt::format(
          "{} points, {} faults, {} failed tries, {} lives, {} deaths: {} lost, {} repeated "
          "or invalid; {} combinations of parameters within {:.1f} sigma",
          c.points, c.faults, c.failed_tries, c.lives, c.deaths, c.lost, c.wrong, c.parameters,
          c.worst_sigma),
      c.points == points && c.faults > points / 20 && c.lost + c.wrong == 0 && c.parameters > 0 &&
          c.worst_sigma < 4.5,
      c.first_problem);
  row("control: a program that acknowledges a point when it begins it", "must lose",
      fmt::format("{} of {} lives end with a loss", c.early, c.lives), c.early > 0);
}

void hostile_rows(const TempFolder& folder, double seconds, std::int64_t most) {
  std::int64_t tried = 0;
  for (const Importer& importer : importers(folder.path())) {
    const MutationCount c = mutate(importer, folder.path(), seconds, most, 20240501);
    tried += c.tried;
    row("mutated " + importer.name, "0 crashes, 0 hangs over 5 s",
        fmt::format("{} tried, {} refused: {} crashes, {} hangs", c.tried, c.refused, c.crashes,
                    c.hangs),
        c.crashes + c.hangs == 0 && c.tried > 0, c.first_problem);
  }
  row("mutated files", ">= 10,000 in all", fmt::format("{}", tried), tried >= 10'000);
  const MutationCount c = mutate(faulty_importer(), folder.path(), 60, 8, 1);
  row("control: an importer that crashes and hangs", "must be caught",
      fmt::format("{} tried: {} crashes, {} hangs", c.tried, c.crashes, c.hangs),
      c.crashes > 0 && c.hangs > 0);
}

}  // namespace

}  // namespace trammel::test

int main(int argc, char** argv) {
  using namespace trammel::test;
  CLI::App app("Measures how safe the data is", "trammel_stress");
  std::vector<std::string> parts;
  double seconds = 60;
  int kills = 60, points = 400, runs = 40;
  bool whole = false;
  std::int64_t most = 1'000'000'000;
  app.add_option("PART", parts,
                 "power, faults, kills, verify, wires, soak, bench, files, hostile (all of them)");
  app.add_flag("--whole", whole,
               "each operation, line and byte; 500 kills, 2,000 points, 1,000 runs of the bench");
  app.add_option("--seconds", seconds, "of mutations for each importer");
  app.add_option("--most", most, "mutations for each importer");
  CLI::Option* of_kills = app.add_option("--kills", kills, "to hit");
  CLI::Option* of_points = app.add_option("--points", points, "of the soak");
  CLI::Option* of_runs = app.add_option("--runs", runs, "of the bench, lies and stops in all");
  CLI11_PARSE(app, argc, argv);
  if (whole && of_kills->count() == 0) kills = 500;
  if (whole && of_points->count() == 0) points = 2000;
  if (whole && of_runs->count() == 0) runs = 1000;
  const auto wanted = [&parts](const char* part) {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  const TempFolder folder;
  fmt::print("| figure | demand | measured | |\n|---|---|---|---|\n");
  if (wanted("power")) power_rows(folder, whole);
  if (wanted("faults")) fault_rows(folder, whole);
  if (wanted("kills")) {
    kill_row(folder, kills);
    socket_kill_row(folder, points, kills / 10);
  }
  if (wanted("verify")) verify_row(folder, whole);
  if (wanted("wires")) wire_rows(whole);
  if (wanted("soak")) soak_row(points);
  if (wanted("bench")) {  // stops cost seconds of the wall each
    bench_rows(lying_bench(std::max(1, runs * 9 / 10 / kinds_of_lies()), kSeed));
    bench_rows(stop_bench(std::max(1, runs / 140), kSeed));
    bench_rows(signal_bench(std::max(1, runs / 200)));
  }
  if (wanted("files")) bench_rows(file_bench(std::max(1, runs / 20), kSeed));
  if (wanted("bench") && wanted("files")) {
    row("bench: lies, stops, signals and files", fmt::format(">= {} runs", runs),
        fmt::format("{} runs, each judged above", n_bench_runs), n_bench_runs >= runs);
  }
  if (wanted("hostile")) hostile_rows(folder, seconds, most);
  return n_missed == 0 ? 0 : 1;
}
