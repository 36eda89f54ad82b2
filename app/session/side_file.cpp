#include "app/session/side_file.hpp"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/files/files.hpp"
#include "core/error.hpp"
#include "store/digest.hpp"
#include "store/transaction.hpp"

namespace trammel::session {

namespace {

using SideJson = nlohmann::json;  // keys are sorted: the digest needs one order

constexpr const char* kSchema = "trammel/unsaved-reading/1";
constexpr std::size_t kMaxSideBytes = 256'000'000;
// One line: a session ends with the first reading that is kept aside. Three answers of at most 4
// KiB each, six times that where every byte is escaped, and the numbers.
constexpr std::size_t kRoomBytes = 128 * 1024;

std::string digest_of(const SideJson& json) {
  // The order of the side files there are.
  return store::hex((store::Digest(store::ByteOrder::little) << json.dump()).finish());
}

SideJson three(const Displacements& l) { return {l[0], l[1], l[2]}; }
SideJson three(const Pose& p) { return {p.x_mm, p.y_mm, p.phi_rad}; }

Displacements displacements(const SideJson& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}
Pose pose(const SideJson& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

SideJson json_of(const UnsavedReading& unsaved) {
  const Reading& r = unsaved.reading.reading;
  SideJson json = {{"schema", kSchema},
                   {"campaign", unsaved.campaign_uuid},
                   {"session", unsaved.session},
                   {"point", unsaved.point_seq},
                   {"epoch", unsaved.epoch},
                   {"set", store::name_of(r.set)},
                   {"target_mm_rad", three(r.target)},
                   {"cmd_mm", three(r.conditions.cmd_mm)},
                   {"from_mm", three(r.conditions.from_mm)}};
  if (r.measured) json["measured_mm_rad"] = three(*r.measured);
  if (r.conditions.time_s) json["time_s"] = *r.conditions.time_s;
  if (r.conditions.temp_degc) json["temp_degc"] = *r.conditions.temp_degc;
  if (unsaved.reading.encoder_mm) json["encoder_mm"] = three(*unsaved.reading.encoder_mm);
  if (unsaved.reading.raw_reply) json["raw_reply"] = *unsaved.reading.raw_reply;
  return json;
}

UnsavedReading unsaved_from(const SideJson& json) {
  UnsavedReading unsaved{.campaign_uuid = json.at("campaign").get<std::string>(),
                         .session = json.at("session").get<std::string>(),
                         .point_seq = json.at("point").get<int>(),
                         .epoch = json.at("epoch").get<int>(),
                         .reading = {}};
  Reading& r = unsaved.reading.reading;
  r.set = store::reading_set(json.at("set").get<std::string>());
  r.target = pose(json.at("target_mm_rad"));
  r.conditions.cmd_mm = displacements(json.at("cmd_mm"));
  r.conditions.from_mm = displacements(json.at("from_mm"));
  r.conditions.epoch = unsaved.epoch;
  if (json.contains("measured_mm_rad")) r.measured = pose(json.at("measured_mm_rad"));
  if (json.contains("time_s")) r.conditions.time_s = json.at("time_s").get<double>();
  if (json.contains("temp_degc")) r.conditions.temp_degc = json.at("temp_degc").get<double>();
  if (json.contains("encoder_mm"))
    unsaved.reading.encoder_mm = displacements(json.at("encoder_mm"));
  if (json.contains("raw_reply")) {
    unsaved.reading.raw_reply = json.at("raw_reply").get<std::string>();
  }
  return unsaved;
}

/// Throws InputError for a line that is not what keep_aside wrote.
UnsavedReading read_line(const std::string& line, const store::CampaignRow& campaign) {
  const auto refuse = [](const std::string& what) { throw InputError({.what = what}); };
  try {
    SideJson json = SideJson::parse(line);
    const std::string digest = json.at("sha256").get<std::string>();
    json.erase("sha256");
    if (json.at("schema") != kSchema) refuse("is no unsaved reading");
    if (digest_of(json) != digest) refuse("is not what was written (sha256)");
    UnsavedReading unsaved = unsaved_from(json);
    if (unsaved.campaign_uuid != campaign.uuid) refuse("is of another campaign");
    return unsaved;
  } catch (const SideJson::exception& error) {
    throw InputError({.what = "cannot be read", .got = error.what()});
  }
}

/// What stands in the database for the line's point, if its attempt is ok.
std::optional<store::NewReading> stored_for(store::Connection& connection, store::Id campaign,
                                            store::Id session, int point_seq) {
  std::optional<store::Id> attempt;
  for (const store::Attempt& a : store::attempts(connection, session)) {
    if (a.point_seq == point_seq && a.status == "ok") attempt = a.id;
  }
  if (!attempt) return std::nullopt;
  for (const store::StoredReading& r : store::readings(connection, campaign, {session})) {
    if (r.attempt_id == attempt) return r.data;
  }
  return std::nullopt;
}

bool same(const UnsavedReading& line, const store::NewReading& stored) {
  UnsavedReading copy = line;
  copy.reading = stored;
  return json_of(copy) == json_of(line) &&
         stored.reading.conditions.epoch == line.reading.reading.conditions.epoch;
}

store::Id attempt_for(store::Connection& connection, store::Id session,
                      const UnsavedReading& line) {
  for (const store::Attempt& a : store::attempts(connection, session)) {
    if (a.point_seq == line.point_seq && a.status == "open" && a.epoch == line.epoch) return a.id;
  }
  for (const store::Epoch& epoch : store::epochs(connection, session)) {
    if (epoch.number == line.epoch) {
      return store::begin_attempt(connection, session, line.point_seq, epoch.id);
    }
  }
  throw InputError({.what = "is of an epoch that the session does not have"});
}

void take(store::Connection& connection, const store::CampaignRow& campaign,
          const std::string& text, bool dry, Recovery& recovery) {
  const UnsavedReading line = read_line(text, campaign);
  const auto session = store::find_session(connection, campaign.id, line.session);
  if (!session)
    throw InputError({.what = "is of a session that is not there", .got = line.session});
  const auto there = stored_for(connection, campaign.id, session->id, line.point_seq);
  if (there) {
    if (!same(line, *there)) {
      throw InputError(
          {.what = fmt::format("point {} has another reading by now", line.point_seq)});
    }
    ++recovery.n_there;
    return;
  }
  ++recovery.n_taken;
  if (dry) return;
  store::hold_clock(connection, session->id);
  store::Transaction transaction(connection);
  store::finish_attempt(connection, attempt_for(connection, session->id, line), {line.reading});
  store::add_event(connection, session->id, "recovered",
                   fmt::format("point {}: its reading was kept aside", line.point_seq));
  transaction.commit();
  const auto now = stored_for(connection, campaign.id, session->id, line.point_seq);
  if (!now || !same(line, *now)) {
    throw StoreError(
        {.what = fmt::format("point {} did not read back as it was kept aside", line.point_seq),
         .where = {.file = connection.file().string()},
         .hint = "run `trammel db verify`; the side file is left as it is"});
  }
}

}  // namespace

std::filesystem::path side_file(const std::filesystem::path& database, const std::string& uuid) {
  return std::filesystem::weakly_canonical(database).string() + "." + uuid + ".unsaved.jsonl";
}

SideRoom::SideRoom(const std::filesystem::path& side_file) : file_(side_file) {
  reserve_room(file_, kRoomBytes);
}

SideRoom::~SideRoom() {
  std::error_code error;
  if (std::filesystem::file_size(file_, error) == 0) std::filesystem::remove(file_, error);
}

void keep_aside(const std::filesystem::path& file, const UnsavedReading& reading) {
  // A device's raw reply may be no UTF-8: what is no character is replaced before it is digested.
  const auto replace = SideJson::error_handler_t::replace;
  SideJson json = SideJson::parse(json_of(reading).dump(-1, ' ', false, replace));
  json["sha256"] = digest_of(json);
  append_line_durably(file, json.dump());
}

Recovery recover(store::Connection& connection, const store::CampaignRow& campaign, bool dry) {
  Recovery recovery;
  const std::filesystem::path file = side_file(connection.file(), campaign.uuid);
  if (!std::filesystem::exists(file)) return recovery;
  const std::string content = read_file(file, kMaxSideBytes);
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = content.find('\n', begin)) != content.npos; begin = end + 1) {
    ++recovery.n_lines;
    try {
      take(connection, campaign, content.substr(begin, end - begin), dry, recovery);
    } catch (const InputError& error) {
      recovery.problems.push_back(
          fmt::format("{}:{}: {}", file.string(), recovery.n_lines, error.what()));
    }
  }
  if (!dry && recovery.problems.empty()) std::filesystem::remove(file);
  return recovery;
}

}  // namespace trammel::session
