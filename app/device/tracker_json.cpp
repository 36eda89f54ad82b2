#include "app/device/tracker_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/device/file_tracker.hpp"
#include "app/device/t2sa.hpp"
#include "app/device/thermometers.hpp"
#include "app/files/fields.hpp"
#include "app/files/files.hpp"
#include "app/files/format.hpp"
#include "app/files/points_format.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace trammel::device {

namespace {

constexpr double kPointTakesS = 3;  // for the estimate of a session's length

/// What is read from the file before it is known which tracker it becomes.
struct TrackerFields {
  std::filesystem::path folder;
  NestSettings nests;
  std::vector<T2saTarget> points;
  std::string object_group = {}, object_reference = {};
  std::vector<T2saTarget> base_points;
  std::vector<NestPoint> base;
  bool has_base_frame = false;
  TrackerSigma sigma;
};

std::filesystem::path beside(const std::filesystem::path& folder, const std::string& file) {
  return folder / file;  // an absolute path stays as it is
}

double positive(Fields& fields, const char* name, double absent) {
  const double value = fields.number(name, absent);
  if (!(value > 0)) fields.refuse(name, "a value that is not positive");
  return value;
}

Eigen::Vector3d read_place(Fields& fields) {
  return {fields.number("x_mm"), fields.number("y_mm"), fields.number("z_mm", 0)};
}

/// No line end, nor more or fewer parts than T2SA's grammar has: the line would be another command.
std::string read_address(Fields& fields, const char* name, int parts) {
  const std::string text = fields.text(name);
  if (text.empty() || text.find_first_of("\r\n") != std::string::npos ||
      std::count(text.begin(), text.end(), ';') != parts - 1) {
    fields.refuse(name, "no name of T2SA", parts == 3 ? "collection;group;point" : "a group");
  }
  return text;
}

/// Two sides that chance can't tell apart: the nests can be exchanged, and no look at the sides
/// shows it.
void refuse_symmetry(Fields& top, const NestSettings& nests) {
  constexpr double kSigmas = 6;
  const std::string why = top.text("symmetric_because", "");
  const std::vector<NestPoint>& body = nests.frame.body;
  if (body.size() != 3 || !why.empty()) return;
  const double apart_mm =
      kSigmas * std::sqrt(2.0) * std::hypot(nests.sigma_mm, nests.frame.u_nest_mm);
  std::array<double, 3> sides_mm{};
  for (std::size_t k = 0; k < 3; ++k) {
    sides_mm[k] = (body[k].at_mm - body[(k + 1) % 3].at_mm).norm();
  }
  std::ranges::sort(sides_mm);
  if (sides_mm[1] - sides_mm[0] > apart_mm && sides_mm[2] - sides_mm[1] > apart_mm) return;
  top.refuse("nests", "a triangle with equal sides: exchanged nests would not be seen",
             fmt::format("sides that differ by more than {:.3f} mm, or \"symmetric_because\": a "
                         "reason",
                         apart_mm));
}

void read_nests(Fields& top, TrackerFields& tracker, bool with_points) {
  for (Fields& nest : top.objects("nests")) {
    const std::string name = nest.text("name");
    tracker.nests.frame.body.push_back({name, read_place(nest)});
    if (with_points) tracker.points.push_back({name, read_address(nest, "point", 3)});
    nest.done();
  }
  tracker.nests.sigma_mm = top.number("sigma_mm");
  if (!(tracker.nests.sigma_mm > 0)) top.refuse("sigma_mm", "a sigma that is not positive");
  tracker.nests.frame.u_nest_mm = top.number("u_nest_mm", 0);
  if (!(tracker.nests.frame.u_nest_mm >= 0)) top.refuse("u_nest_mm", "a negative uncertainty");
  tracker.nests.out_of_plane_mm = top.optional_number("out_of_plane_mm");
  if (tracker.nests.frame.body.size() < 2) {
    top.refuse("nests", "one nest shows where the platform is, not how it is turned",
               "two or three nests, or an object");
  }
  refuse_symmetry(top, tracker.nests);
}

void read_object(Fields object, TrackerFields& tracker) {
  tracker.object_group = read_address(object, "group", 1);
  if (object.has("reference")) tracker.object_reference = read_address(object, "reference", 1);
  tracker.sigma = {object.number("sigma_xy_mm"), rad_from_deg(object.number("sigma_phi_deg"))};
  if (!(tracker.sigma.xy_mm > 0 && tracker.sigma.phi_rad > 0)) {
    object.refuse("sigma_xy_mm", "a sigma that is not positive");
  }
  tracker.nests.sigma_mm = tracker.sigma.xy_mm;
  object.done();
}

void read_base(Fields& top, TrackerFields& tracker, bool may_measure) {
  if (auto frame = top.optional_object("base_frame")) {
    const Eigen::Vector3d angles_deg = {frame->number("rx_deg", 0), frame->number("ry_deg", 0),
                                        frame->number("rz_deg", 0)};
    tracker.nests.frame.T_B_T = fixed_axes(read_place(*frame), angles_deg * rad_from_deg(1));
    tracker.has_base_frame = true;
    frame->done();
  }
  if (!may_measure || !top.has("base_nests")) return;
  if (tracker.has_base_frame) top.refuse("base_nests", "a base frame is stated already");
  for (Fields& nest : top.objects("base_nests")) {
    const std::string name = nest.text("name");
    tracker.base.push_back({name, read_place(nest)});
    tracker.base_points.push_back({name, read_address(nest, "point", 3)});
    nest.done();
  }
  if (tracker.base.size() < 3) top.refuse("base_nests", "fewer than three give no frame");
}

std::unique_ptr<Tracker> read_t2sa(Fields source, const TrackerFields& tracker, bool emulated) {
  T2saSettings s;
  s.server = {source.text("host"), source.integer("port")};
  if (s.server.port < 1 || s.server.port > 65'535) source.refuse("port", "no TCP port");
  s.connect_timeout_s = positive(source, "connect_timeout_s", s.connect_timeout_s);
  s.reply_timeout_s = positive(source, "reply_timeout_s", s.reply_timeout_s);
  s.warm_up_s = positive(source, "warm_up_s", s.warm_up_s);
  source.done();
  s.by_host_clock = !emulated;
  s.nests = tracker.nests;
  s.points = tracker.points;
  s.object_group = tracker.object_group;
  s.object_reference = tracker.object_reference;
  s.base_points = tracker.base_points;
  s.base = tracker.base;
  return std::make_unique<T2saTracker>(std::move(s));
}

std::unique_ptr<Tracker> read_file_source(Fields source, const TrackerFields& tracker,
                                          FileTrackerSettings& s) {
  s.file = beside(tracker.folder, source.text("file"));
  std::vector<std::string> formats;
  for (const PointsFormat& format : points_formats()) formats.emplace_back(format.name);
  s.format.format = source.choice("format", formats, "");
  s.format.unit = source.text("unit", "");
  if (!s.format.unit.empty()) {
    try {
      static_cast<void>(mm_of_unit(s.format.unit));
    } catch (const InputError& error) {
      source.refuse("unit", error.text().what, error.text().expected);
    }
  }
  if (source.has("date")) {
    const bool day = source.choice("date", {"day-first", "month-first"}) == "day-first";
    s.format.date = day ? DateOrder::day_first : DateOrder::month_first;
  }
  s.format.decimal = source.choice("decimal", {".", ","}, ".")[0];
  s.by_name = source.choice("rows", {"in order", "by name"}, "in order") == "by name";
  s.timeout_s = positive(source, "timeout_s", s.timeout_s);
  s.poll_s = positive(source, "poll_s", s.poll_s);
  source.done();
  s.nests = tracker.nests;
  return std::make_unique<FileTracker>(s);
}

std::unique_ptr<Thermometer> read_thermometer(Fields fields, const std::filesystem::path& folder,
                                              const FileTrackerSettings* file) {
  const std::string source = fields.choice("source", {"fixed", "file", "tracker"});
  std::unique_ptr<Thermometer> thermometer;
  if (source == "fixed") {
    thermometer = fixed_thermometer(fields.number("temp_degc"));
  } else if (source == "file") {
    thermometer =
        logged_thermometer(beside(folder, fields.text("file")), positive(fields, "max_age_s", 600));
  } else if (file != nullptr) {
    thermometer =
        tracker_thermometer(file->file, file->format, fields.optional_number("first_degc"));
  } else {
    fields.refuse("source", "T2SA reports no temperature", "file or fixed");
  }
  fields.done();
  return thermometer;
}

TrackerFile read_tracker_fields(Fields top, const std::filesystem::path& folder) {
  take_format(top, "tracker/1");
  static_cast<void>(top.text("name", ""));
  static_cast<void>(top.text("why", ""));
  TrackerFile result;
  result.emulated = top.boolean("emulated", false);
  Fields source = top.object("source");
  result.kind = source.choice("type", {"t2sa", "file"});
  const bool t2sa = result.kind == "t2sa";
  TrackerFields tracker;
  tracker.folder = folder;
  read_base(top, tracker, t2sa);
  auto object = t2sa ? top.optional_object("object") : std::nullopt;
  if (object) {
    read_object(*object, tracker);
  } else {
    read_nests(top, tracker, t2sa);
    tracker.sigma = sigma_of_pose(tracker.nests);
  }
  result.sigma = tracker.sigma;
  result.measure_s =
      kPointTakesS * static_cast<double>(std::max<std::size_t>(1, tracker.nests.frame.body.size()));
  FileTrackerSettings file;
  result.tracker =
      t2sa ? read_t2sa(source, tracker, result.emulated) : read_file_source(source, tracker, file);
  result.thermometer = read_thermometer(top.object("temperature"), folder, t2sa ? nullptr : &file);
  top.done();
  return result;
}

}  // namespace

TrackerFile parse_tracker(std::string_view text, const std::filesystem::path& path) {
  const JsonFile file = parse_json(text, path.string());
  try {
    return read_tracker_fields(Fields(file), path.parent_path());
  } catch (const InputError& error) {
    if (error.text().where.line > 0) throw;
    throw located(error, file);  // of core, which knows no file
  }
}

TrackerFile read_tracker(const std::filesystem::path& path) {
  return parse_tracker(read_file(path, kMaxJsonBytes), path);
}

}  // namespace trammel::device
