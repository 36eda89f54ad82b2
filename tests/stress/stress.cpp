// The figures on the safety of data, measured: scripts/stress. The small version is
// the tests of this folder.

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "store/job.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/stress/byte_sweep.hpp"
#include "tests/stress/faults.hpp"
#include "tests/stress/kills.hpp"
#include "tests/stress/mutate.hpp"
#include "tests/stress/power_loss.hpp"
#include "tests/stress/soak.hpp"

namespace trammel::test {

namespace {

int n_missed = 0;

void row(const std::string& figure, const std::string& demand, const std::string& measured,
         bool reached, const std::string& problem = "") {
  fmt::print("| {} | {} | {} | {} |\n", figure, demand, measured, reached ? "reached" : "MISSED");
  if (!reached && !problem.empty()) fmt::print(stderr, "{}: {}\n", figure, problem);
  std::fflush(stdout);
  n_missed += reached ? 0 : 1;
}

void power_rows(const TempFolder& folder) {
  const auto text = [](const PowerLossCount& c) {
    return fmt::format(
        "{} images of {} operations: {} with a loss (up to {} points), {} corrupt; "
        "{} sessions finished from one, {} wrong",
        c.images, c.operations, c.lost_images, c.lost_points, c.corrupt, c.resumed,
        c.wrong_resumes);
  };
  const auto run = [&folder](PowerLossOptions options) {
    std::filesystem::remove_all(folder.file("power"));
    std::filesystem::create_directory(folder.file("power"));
    return lose_power(folder.file("power"), options);
  };
  const PowerLossCount c = run({.n_points = 60});
  row("power loss: unsynced writes dropped, torn, reordered", ">= 10,000 images, 0 lost, 0 corrupt",
      text(c), c.images >= 10'000 && c.lost_images == 0 && c.corrupt == 0 && c.wrong_resumes == 0,
      c.first_problem);
  const PowerLossCount normal =
      run({.n_points = 20, .every = 5, .resume_every = 0, .durability = Durability::normal});
  row("control: synchronous=NORMAL", "must lose", text(normal), normal.lost_images > 0);
  const PowerLossCount lies = run({.n_points = 20, .every = 5, .resume_every = 0, .lies = true});
  row("control: a disk that lies about sync", "must lose", text(lies), lies.lost_images > 0);
}

void fault_rows(const TempFolder& folder) {
  struct Case {
    const char* name;
    Fault fault;
  };
  for (const Case& c : {Case{"I/O error", Fault::io_error}, Case{"disk full", Fault::disk_full},
                        Case{"out of memory", Fault::out_of_memory}}) {
    for (const bool for_good : {false, true}) {
      const std::int64_t every = c.fault == Fault::out_of_memory ? 3 : 1;
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
      ">= 500 kills: 0 acknowledged readings lost, none repeated",
      fmt::format("{} kills of {} campaigns ({} after an acknowledged point): {} lost, {} corrupt, "
                  "{} repeated, {} with other bits",
                  c.kills, c.campaigns, c.with_points, c.lost, c.corrupt, c.repeated, c.different),
      c.kills >= 500 && c.lost + c.corrupt + c.repeated + c.different == 0, c.first_problem);
  const TempFolder apart;
  const KillCount torn = sweep_kills(apart.path(), {.kills = 50, .loses_log = true});
  row("control: a log that does not outlive the kill", "must lose",
      torn.lost > 0 ? torn.first_problem : fmt::format("0 lost in {} kills", torn.kills),
      torn.lost > 0);
}

void verify_row(const TempFolder& folder) {
  const auto file = folder.file("verify.db"), copy = folder.file("verify-copy.db");
  {
    store::Connection db = store::open(file, store::Access::create);
    const store::Id campaign =
        store::import_campaign(db, small_campaign(), {{2, "{}"}}).campaign_id;
    store::add_event(db, measured_session(db, campaign, "baseline", 12), "done");
    store::exclude_reading(db, campaign, 2, "bumped");
  }
  store::Connection(file, store::Access::write).execute("VACUUM INTO '" + copy.string() + "'");
  SweepCount all{.untouched_is_clean = true};
  for (const char* table : {"reading", "point", "attempt", "epoch", "session", "campaign",
                            "campaign_chain", "campaign_fact", "exclusion", "session_event"}) {
    const SweepCount c = sweep_bytes(copy, {.table = table, .masks = {0x01, 0x80, 0xFF}});
    all.rows += c.rows;
    all.bytes += c.bytes;
    all.found += c.found;
    all.named += c.named;
    all.untouched_is_clean = all.untouched_is_clean && c.untouched_is_clean;
    if (all.first_miss.empty()) all.first_miss = c.first_miss;
  }
  row("db verify: single changed bytes in raw rows", "all found, the row named",
      fmt::format("{} changes of {} rows of 10 tables: {} found, {} named", all.bytes, all.rows,
                  all.found, all.named),
      all.untouched_is_clean && all.found == all.bytes && all.named == all.bytes, all.first_miss);
  const SweepCount plain = sweep_bytes(copy, {.look = store::check});
  row("control: SQLite's own integrity_check", "must miss some",
      fmt::format("{} changes of {} readings: {} found", plain.bytes, plain.rows, plain.found),
      plain.found < plain.bytes);
}

void wire_rows() {
  for (const auto kind : {emulate::FaultKind::lost_reply, emulate::FaultKind::half_reply,
                          emulate::FaultKind::dropped}) {
    const WireCount c = sweep_wires(kind);
    row(fmt::format("{} at each line of a campaign over sockets", emulate::name_of(kind)),
        "each point stored once and as it was",
        fmt::format("{} campaigns of 4 points, {} resumed: {} wrong", c.runs, c.resumed, c.wrong),
        c.runs > 100 && c.wrong == 0, c.first_problem);
  }
}

void soak_row(int points) {
  const SoakCount c = soak_over_sockets({.n_points = points});
  row("soak over sockets: emulators, drivers, runner, random faults, stops and deaths",
      ">= 2,000 points: 0 acknowledged lost, 0 repeated or invalid, parameters as without faults",
      fmt::format(
          "{} points, {} faults, {} failed tries, {} lives, {} deaths: {} lost, {} repeated "
          "or invalid; {} combinations of parameters within {:.1f} sigma",
          c.points, c.faults, c.failed_tries, c.lives, c.deaths, c.lost, c.wrong, c.parameters,
          c.worst_sigma),
      c.points >= 2000 && c.faults > points / 20 && c.lost + c.wrong == 0 && c.parameters > 0 &&
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
  int kills = 500, points = 2000;
  std::int64_t most = 1'000'000'000;
  app.add_option("PART", parts, "power, faults, kills, verify, wires, soak, hostile (all of them)");
  app.add_option("--seconds", seconds, "of mutations for each importer");
  app.add_option("--most", most, "mutations for each importer");
  app.add_option("--kills", kills, "to hit");
  app.add_option("--points", points, "of the soak");
  CLI11_PARSE(app, argc, argv);
  const auto wanted = [&parts](const char* part) {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  const TempFolder folder;
  fmt::print("| figure | demand | measured | |\n|---|---|---|---|\n");
  if (wanted("power")) power_rows(folder);
  if (wanted("faults")) fault_rows(folder);
  if (wanted("kills")) kill_row(folder, kills);
  if (wanted("verify")) verify_row(folder);
  if (wanted("wires")) wire_rows();
  if (wanted("soak")) soak_row(points);
  if (wanted("hostile")) hostile_rows(folder, seconds, most);
  return n_missed == 0 ? 0 : 1;
}
