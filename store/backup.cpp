#include "store/backup.hpp"

#include "store/new_file.hpp"
#include "store/open.hpp"
#include "store/statement.hpp"

namespace trammel::store {

namespace {

std::string quoted(const std::string& text) {
  std::string sql = "'";
  for (const char c : text) sql += c == '\'' ? "''" : std::string(1, c);
  return sql + "'";
}

CheckReport verified(const std::filesystem::path& copy) {
  Connection connection = open_as_it_is(copy);
  return whole(connection, copy);
}

void require_free(const std::filesystem::path& to) {
  if (!std::filesystem::exists(to)) return;
  throw InputError({.what = "the backup's name is taken",
                    .where = {.file = to.string()},
                    .hint = "name a new file"});
}

}  // namespace

CheckReport backup_check(const std::filesystem::path& file, const std::filesystem::path& to) {
  require_free(to);
  Connection connection = open_as_it_is(file);
  return whole(connection, file);
}

CheckReport backup(const std::filesystem::path& file, const std::filesystem::path& to) {
  require_free(to);
  { open_as_it_is(file); }  // is it ours?
  const Partial partial{to.string() + ".part"};
  { const Partial left_by_a_dead_one{partial.path}; }
  Connection(file, Access::read_only).execute("VACUUM INTO " + quoted(partial.path.string()));
  CheckReport report = verified(partial.path);
  sync(partial.path);
  std::filesystem::rename(partial.path, to);
  sync(std::filesystem::absolute(to).parent_path());
  return report;
}

}  // namespace trammel::store
