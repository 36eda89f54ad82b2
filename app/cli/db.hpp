#pragma once

#include <string>

#include "app/cli/context.hpp"

namespace trammel::cli {

struct DbOptions {
  bool dry_run = false;  // migrate
};
struct DbVerifyOptions {
  std::string head;  // empty: not asked for
};
struct DbBackupOptions {
  std::string to;
  bool dry_run = false;
};

/// `db check`, `verify`, `backup`, `migrate`: the file as a whole.
void setup_db(Command app, Context& context);

ExitCode run_db_check(const DbOptions& options, Context& context);
ExitCode run_db_verify(const DbVerifyOptions& options, Context& context);
ExitCode run_db_backup(const DbBackupOptions& options, Context& context);
ExitCode run_db_migrate(const DbOptions& options, Context& context);

}  // namespace trammel::cli
