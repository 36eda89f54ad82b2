#include "app/archive/station.hpp"

#include <nlohmann/json.hpp>

#include "app/files/files.hpp"
#include "core/error.hpp"

namespace trammel::archive {

namespace {
constexpr const char* kFormat = "trammel/archive-station/1";
constexpr std::size_t kMostBytes = 64 * 1024;
}  // namespace

std::filesystem::path station_file(const std::filesystem::path& database) {
  return database.string() + ".archive.json";
}

std::optional<Station> read_station(const std::filesystem::path& database) {
  const std::filesystem::path file = station_file(database);
  if (!std::filesystem::exists(file)) return std::nullopt;
  const auto json = nlohmann::json::parse(read_file(file, kMostBytes), nullptr, false);
  const auto text = [&json](const char* key) {
    const bool there = json.is_object() && json.contains(key) && json[key].is_string();
    return there ? json[key].get<std::string>() : std::string();
  };
  if (text("schema") != kFormat || text("station").size() != 36 || text("uri").empty()) {
    throw InputError({.what = "this does not say which station this is",
                      .where = {.file = file.string()},
                      .expected = std::string(kFormat) + " with station and uri",
                      .hint = "move it away and run `trammel archive init URI`"});
  }
  return Station{text("station"), text("uri")};
}

void write_station(const std::filesystem::path& database, const Station& station) {
  const nlohmann::ordered_json json = {
      {"schema", kFormat}, {"station", station.uuid}, {"uri", station.uri}};
  write_output(station_file(database), json.dump(2) + "\n", Existing::replace);
}

}  // namespace trammel::archive
