#include "app/files/layout.hpp"

#include <algorithm>
#include <array>

#include "app/files/budget_json.hpp"
#include "app/files/fields.hpp"
#include "app/files/format.hpp"

namespace trammel {

namespace {

constexpr double kMaxNestMm = 1e5;

void read_point_options(Fields fields, PointsOptions& options) {
  std::vector<std::string> names;
  for (const PointsFormat& format : points_formats()) names.emplace_back(format.name);
  options.format = fields.choice("format", names, "");
  options.unit = fields.choice("unit", {"mm", "m", "um", "in"});
  options.decimal = fields.choice("decimal", {".", ","}, ".").front();
  options.date = date_order(fields.choice("date", date_order_names(), ""));
  if (fields.has("misses")) {
    options.misses.clear();
    for (const std::string& word : fields.texts("misses")) {
      bool known = false;
      for (const Miss miss : {Miss::zero, Miss::empty, Miss::deleted}) {
        if (word == name_of(miss)) options.misses.insert(miss);
        known = known || word == name_of(miss);
      }
      if (!known) fields.refuse("misses", "unknown way to write a miss", "zero, empty, deleted");
    }
  }
  fields.done();
}

std::vector<NestPoint> read_nests(Fields& owner, std::string_view field, std::size_t least) {
  std::vector<NestPoint> nests;
  for (Fields& nest : owner.objects(field)) {
    NestPoint point{nest.text("nest"),
                    {nest.number("x_mm"), nest.number("y_mm"), nest.number("z_mm", 0)}};
    if (point.nest.empty()) nest.refuse("nest", "a nest without a name");
    if (point.at_mm.cwiseAbs().maxCoeff() > kMaxNestMm) {
      nest.refuse("", "the place is out of all bounds", "mm", "is the unit right?");
    }
    for (const NestPoint& other : nests) {
      if (other.nest == point.nest) nest.refuse("nest", "duplicate nest");
    }
    nest.done();
    nests.push_back(std::move(point));
  }
  if (nests.size() < least) {
    owner.refuse(field, "too few nests: got " + std::to_string(nests.size()),
                 std::to_string(least) + " or more",
                 least == 2
                     ? "one nest shows no phi (orientation), and a reading needs it: measure a "
                       "second one, or look at bare points by `trammel campaign points`"
                     : "");
  }
  return nests;
}

struct NamedAxis {
  std::string name;
  Eigen::Vector3d axis;
};
const std::array<NamedAxis, 6> kAxes = {{{"+x", {1, 0, 0}},
                                         {"-x", {-1, 0, 0}},
                                         {"+y", {0, 1, 0}},
                                         {"-y", {0, -1, 0}},
                                         {"+z", {0, 0, 1}},
                                         {"-z", {0, 0, -1}}}};

Layout::Frame read_frame(Fields fields) {
  Layout::Frame frame;
  const std::string from = fields.choice("from", {"robot", "base-nests", "zeroing"});
  if (from == "base-nests") {
    frame.from = FrameFrom::base_nests;
    frame.base = read_nests(fields, "nests", 3);
    frame.false_alarm = fields.number("false_alarm", frame.false_alarm);
    if (!(frame.false_alarm > 0 && frame.false_alarm < 1)) {
      fields.refuse("false_alarm", "no share", "between 0 and 1");
    }
  } else if (from == "zeroing") {
    frame.from = FrameFrom::zeroing;
    std::vector<std::string> names;
    for (const NamedAxis& axis : kAxes) names.push_back(axis.name);
    const std::string up = fields.choice("up", names);
    for (const NamedAxis& axis : kAxes) {
      if (axis.name == up) frame.up = axis.axis;
    }
  }
  fields.done();
  return frame;
}

bool has_place(const std::string& text, const char* place) {
  return text.find(place) != std::string::npos;
}

void require_places(const Fields& fields, const Layout::Rows& rows) {
  const std::string both = rows.point + "\n" + rows.group;
  for (const char* place : {"{pose}", "{nest}"}) {
    if (!has_place(both, place)) {
      fields.refuse("point", std::string("the names do not say the ") + place,
                    "{pose} and {nest} in point or group");
    }
  }
}

Layout::Rows read_rows(Fields fields, const Layout& layout) {
  Layout::Rows rows;
  rows.by_name = fields.choice("by", {"name", "order"}) == "name";
  if (rows.by_name) {
    rows.point = fields.text("point");
    rows.group = fields.text("group", "");
    require_places(fields, rows);
  } else {
    rows.nests = fields.texts("nests");
    rows.repeats = fields.integer("repeats", 1);
    rows.base_every = fields.integer("base_every", 0);
    if (rows.repeats < 1) fields.refuse("repeats", "no count", "1 or more");
    if (rows.base_every < 0) fields.refuse("base_every", "no count", "0 or more");
    for (const std::string& nest : rows.nests) {
      const auto same = [&nest](const NestPoint& b) { return b.nest == nest; };
      if (std::none_of(layout.body.body.begin(), layout.body.body.end(), same)) {
        fields.refuse("nests", "the platform has no nest " + nest, "names of \"nests\"");
      }
      if (std::count(rows.nests.begin(), rows.nests.end(), nest) > 1) {
        fields.refuse("nests", "duplicate nest " + nest + " in one round", "each once",
                      "say \"repeats\" for more rounds");
      }
    }
    if (rows.nests.size() < 2) fields.refuse("nests", "too few nests in a round", "2 or more");
  }
  rows.mean_of_samples = fields.choice("samples", {"each", "mean"}, "each") == "mean";
  fields.done();
  return rows;
}

}  // namespace

Layout read_layout(const std::filesystem::path& path) {
  const JsonFile file = read_json(path);
  Fields top(file);
  Layout layout;
  layout.file = file.name;
  take_format(top, "layout/1");
  layout.name = top.text("name");
  if (layout.name.empty() || layout.name.size() > 200) {
    top.refuse("name", "a name that can't be used", "1 to 200 letters");
  }
  layout.simulated = top.choice("kind", {"real", "simulated"}) == "simulated";
  layout.mechanism = top.text("mechanism", "");
  layout.plan = top.text("plan", "");
  read_point_options(top.object("points"), layout.points);
  layout.sigma_mm = top.number("sigma_mm");
  if (!(layout.sigma_mm > 0 && layout.sigma_mm < 10)) {
    top.refuse("sigma_mm", "no standard deviation of a tracker's point", "mm, above 0",
               "of one coordinate: 0.005 for a good tracker at 2 m");
  }
  layout.body.body = read_nests(top, "nests", 2);
  layout.body.u_nest_mm = top.number("u_nest_mm", 0);
  if (!(layout.body.u_nest_mm >= 0 && layout.body.u_nest_mm < 10)) {
    top.refuse("u_nest_mm", "no standard uncertainty of a nest's place", "mm, 0 or more");
  }
  layout.frame = read_frame(top.object("frame"));
  layout.rows = read_rows(top.object("rows"), layout);
  for (const NestPoint& base : layout.frame.base) {
    for (const NestPoint& nest : layout.body.body) {
      if (nest.nest == base.nest) {
        top.refuse("nests", "nest " + nest.nest + " is on the platform and on the base");
      }
    }
  }
  if (auto facts = top.optional_object("facts")) {
    if (auto budget = facts->optional_object(kBudgetFact)) {
      layout.facts[kBudgetFact] = read_budget(*budget);
    }
    for (auto& [key, value] : facts->text_pairs()) layout.facts[key] = value;
  }
  top.done();
  return layout;
}

}  // namespace trammel
