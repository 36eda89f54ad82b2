#include "app/archive/install.hpp"

namespace trammel::archive {

namespace {
int newest() { return static_cast<int>(archive_schema().size()); }
}  // namespace

int archive_version(Link& link) {
  if (!link.ask("SELECT to_regclass('trammel.archive')::text").at(0).at(0)) return 0;
  return static_cast<int>(number_of(link.ask("SELECT max(version) FROM trammel.archive").at(0), 0));
}

bool install(Link& link) {
  const Link::Transaction nobody_else_meanwhile(link);
  link.run("SELECT pg_advisory_xact_lock(hashtext('trammel archive'))");
  const int version = archive_version(link);
  if (version >= newest()) return false;
  for (int k = version; k < newest(); ++k) {
    link.run(std::string(archive_schema()[static_cast<std::size_t>(k)]));
  }
  link.commit();
  return true;
}

void require_archive(Link& link) {
  const int version = archive_version(link);
  if (version == 0) {
    throw NotFoundError({.what = "there is no archive in this database",
                         .hint = "its owner makes one: trammel archive init URI"});
  }
  if (version == newest()) return;
  throw StoreError({.what = version > newest() ? "this archive was made by a newer trammel"
                                               : "this archive was made by an older trammel",
                    .got = "version " + std::to_string(version),
                    .expected = "version " + std::to_string(newest()),
                    .hint = version > newest() ? "use the program of that version"
                                               : "its owner brings it up to date: trammel archive "
                                                 "init URI"});
}

}  // namespace trammel::archive
