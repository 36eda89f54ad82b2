#pragma once
// Who a station is to the archive, and where its archive is: a small file beside the database.

#include <filesystem>
#include <optional>
#include <string>

namespace trammel::archive {

struct Station {
  std::string uuid;
  std::string uri;
};

/// FILE.archive.json of the database FILE.
std::filesystem::path station_file(const std::filesystem::path& database);

/// Nothing where there is no such file. @throws InputError  it is not what write_station writes
std::optional<Station> read_station(const std::filesystem::path& database);
void write_station(const std::filesystem::path& database, const Station& station);

}  // namespace trammel::archive
