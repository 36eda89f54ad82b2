#include "app/cli/db.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/terminal/counted.hpp"
#include "store/backup.hpp"
#include "store/migrate.hpp"
#include "store/open.hpp"
#include "store/verify.hpp"

namespace trammel::cli {

namespace {

ExitCode answer(const std::string& command, const store::CheckReport& report,
                const std::string& good, const Context& context) {
  if (context.json) {
    context.print(command, {{"database", context.db()},
                            {"ok", report.ok()},
                            {"n_readings", report.n_readings},
                            {"n_sealed_rows", report.n_sealed},
                            {"findings", report.findings}});
  } else if (report.ok()) {
    context.print(good);
  } else {
    for (const std::string& finding : report.findings) context.print(printable(finding));
  }
  return report.ok() ? ExitCode::ok : ExitCode::not_acceptable;
}

// A head that somebody printed once: of a campaign's readings as they are, at an earlier time, or
// of the older database that they were taken over from.
void require_head(store::Connection& db, const std::string& head, store::CheckReport& report) {
  if (!store::had_head(db, head)) {
    report.findings.push_back(fmt::format("no campaign's readings have had the head {}", head));
  }
}

}  // namespace

ExitCode run_db_check(const DbOptions&, Context& context) {
  store::Connection db = store::open_as_it_is(context.db());
  return answer("db-check", store::check(db), "ok: the file is whole", context);
}

ExitCode run_db_verify(const DbVerifyOptions& options, Context& context) {
  store::Connection db = store::open_as_it_is(context.db());
  store::CheckReport report = store::verify(db);
  if (!options.head.empty()) require_head(db, options.head, report);
  return answer("db-verify", report,
                fmt::format("ok: {} and {} are what was stored",
                            terminal::counted(report.n_readings, "reading"),
                            terminal::counted(report.n_sealed, "other row")),
                context);
}

ExitCode run_db_backup(const DbBackupOptions& options, Context& context) {
  const store::CheckReport report = options.dry_run ? store::backup_check(context.db(), options.to)
                                                    : store::backup(context.db(), options.to);
  if (context.json) {
    context.print("db-backup", {{"database", context.db()},
                                {"backup", options.to},
                                {"n_readings", report.n_readings},
                                {"dry_run", options.dry_run}});
  } else {
    context.print(fmt::format("{} {} to {}: verified, {}",
                              options.dry_run ? "would back up" : "backed up",
                              printable(context.db()), printable(options.to),
                              terminal::counted(report.n_readings, "reading")));
  }
  return ExitCode::ok;
}

ExitCode run_db_migrate(const DbOptions& options, Context& context) {
  const store::Migration done =
      options.dry_run ? store::planned_migration(context.db()) : store::migrate(context.db());
  if (context.json) {
    context.print("db-migrate", {{"database", context.db()},
                                 {"from_version", done.from},
                                 {"to_version", done.to},
                                 {"copy", done.original.string()},
                                 {"dry_run", options.dry_run}});
  } else if (done.from == done.to) {
    context.print(fmt::format("nothing to do: version {}", done.to));
  } else {
    context.print(fmt::format(
        fmt::runtime(options.dry_run
                         ? "would migrate from version {} to {}; the original would be kept as {}"
                         : "migrated from version {} to {}; the original is kept as {}"),
        done.from, done.to, printable(done.original.string())));
  }
  return ExitCode::ok;
}

void setup_db(Command app, Context& context) {
  Command db = noun(app, "db", "The database as a file: check, verify, backup, migrate");
  const auto none = std::make_shared<DbOptions>();
  on_run(db.command("check", "Is the file whole? (pages, indexes, bounds, references)"), context,
         none, run_db_check);
  const auto verify = std::make_shared<DbVerifyOptions>();
  Command proof = db.command("verify", "check, and is every row what was stored? (SHA-256)");
  proof.option("--head", verify->head, "Digest that a report printed: were these readings stored?")
      .type("HEX");
  on_run(proof, context, verify, run_db_verify);
  const auto backup = std::make_shared<DbBackupOptions>();
  Command copy = db.command("backup", "A verified copy, also while a session runs");
  copy.option("--out,FILE", backup->to, "New file").required().type("FILE");
  copy.flag("--dry-run", backup->dry_run, "Verify the database and the name, copy nothing");
  on_run(copy, context, backup, run_db_backup);
  const auto migrate = std::make_shared<DbOptions>();
  Command to_this = db.command("migrate", "Take an older database to this version");
  to_this.flag("--dry-run", migrate->dry_run, "Say from where to where, change nothing");
  on_run(to_this, context, migrate, run_db_migrate);
}

}  // namespace trammel::cli
