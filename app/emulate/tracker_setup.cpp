// The nests and the stand of an emulated tracker: built in, or from a file.

#include <cmath>

#include "app/emulate/tracker.hpp"
#include "app/files/fields.hpp"
#include "app/files/format.hpp"
#include "core/units.hpp"

namespace trammel::emulate {

namespace {

Eigen::Vector3d corner(double radius_mm, double angle_deg, double z_mm) {
  const double angle = rad_from_deg(angle_deg);
  return {radius_mm * std::cos(angle), radius_mm * std::sin(angle), z_mm};
}

Eigen::Vector3d read_place(Fields& fields) {
  return {fields.number("x_mm"), fields.number("y_mm"), fields.number("z_mm", 0)};
}

}  // namespace

Eigen::Isometry3d fixed_frame(const Eigen::Vector3d& at_mm, const Eigen::Vector3d& turned_rad) {
  using Turn = Eigen::AngleAxisd;
  Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
  isometry.linear() = (Turn(turned_rad[2], Eigen::Vector3d::UnitZ()) *
                       Turn(turned_rad[1], Eigen::Vector3d::UnitY()) *
                       Turn(turned_rad[0], Eigen::Vector3d::UnitX()))
                          .toRotationMatrix();
  isometry.translation() = at_mm;
  return isometry;
}

TrackerSetup default_tracker() {
  const double z_mm = 30, base_mm = 500;
  TrackerSetup setup;
  setup.nests = {{"PAIR", "P1", true, {-7.5, 0, z_mm}}, {"PAIR", "P2", true, {7.5, 0, z_mm}}};
  setup.nests.push_back({"PLATFORM", "P1", true, {10, 90, z_mm}});  // no two sides are equal
  setup.nests.push_back({"PLATFORM", "P2", true, {-80, -50, z_mm}});
  setup.nests.push_back({"PLATFORM", "P3", true, {70, -40, z_mm}});
  for (int k = 0; k < 4; ++k) {
    setup.nests.push_back(
        {"BASE", "B" + std::to_string(k + 1), false, corner(base_mm, 45 + 90 * k, 0)});
  }
  setup.from_base =
      fixed_frame({2296.4, -2416.2, -442.6}, rad_from_deg(1) * Eigen::Vector3d(0.8, -0.5, 37));
  return setup;
}

TrackerSetup read_tracker_setup(const std::filesystem::path& path) {
  const JsonFile file = read_json(path);
  Fields top(file);
  TrackerSetup setup;
  take_format(top, "emulated-tracker/1");
  setup.warm_up_s = top.number("warm_up_s", setup.warm_up_s);
  if (setup.warm_up_s < 0) top.refuse("warm_up_s", "time that runs backwards", "0 or more");
  if (auto stand = top.optional_object("from_base")) {
    const Eigen::Vector3d at_mm = read_place(*stand);
    const Eigen::Vector3d turned_deg = {stand->number("rx_deg", 0), stand->number("ry_deg", 0),
                                        stand->number("rz_deg", 0)};
    setup.from_base = fixed_frame(at_mm, rad_from_deg(1) * turned_deg);
    stand->done();
  }
  for (Fields& nest : top.objects("nests")) {
    Nest made;
    made.group = nest.text("group");
    made.point = nest.text("point");
    made.on_platform = nest.choice("on", {"platform", "base"}) == "platform";
    made.at_mm = read_place(nest);
    nest.done();
    setup.nests.push_back(std::move(made));
  }
  top.done();
  return setup;
}

}  // namespace trammel::emulate
